//! Files that a scene names by frame: `sim.####.vdb`. Which there are is looked up once, when the scene is read.

use std::fmt;
use std::ops::RangeInclusive;
use std::path::PathBuf;

use crate::terminal;
use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::files::{Base, FilePlace, FileReference, Variables, expand, suggest_neighbour};
use crate::text::frames::{FrameRange, in_ranges};
use crate::text::pattern::FramePattern;
use crate::text::source::Span;

/// What a frame shows that no file of a sequence has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutsideFrames {
    /// It is an error.
    Error,
    /// The first file, or the last.
    Hold,
    /// The files again from the first.
    Loop,
}

/// A file for each frame of the shot.
#[derive(Clone, Debug)]
pub struct FileSequence {
    /// Its pattern, for messages.
    pub name: String,
    /// Where the scene names it.
    pub span: Span,
    /// The numbers that there are, rising.
    there: Vec<i64>,
    pattern: FramePattern,
    shot: FrameRange,
    offset: i64,
    outside: OutsideFrames,
    /// Those of the files that the shot shows, by number.
    shown: Vec<(i64, FileReference)>,
    /// The first of the numbers between the files that the shot shows and that are missing.
    missing: Vec<i64>,
}

/// The most missing frames that are looked for: names of more say nothing new.
const MOST: usize = 100;

/// The sequence that a path stands for; `None` where it is a file's own name, or has no frame token.
///
/// # Errors
/// A frame token at a wrong place, and a sequence of no file.
pub fn find(
    text: &str,
    span: Span,
    base: &Base,
    variables: &Variables,
    shot: FrameRange,
) -> Result<Option<FileSequence>, Diagnostic> {
    let Base::Folder(folder) = base else { return Ok(None) };
    // `$F4` is the frame's number, as in the names of what is written.
    let is_token = |name: &str| name.strip_prefix('F').is_some_and(|width| width.bytes().all(|b| b.is_ascii_digit()));
    let expanded = expand(text, &|name| if is_token(name) { Some(format!("${name}")) } else { variables(name) });
    let Ok(expanded) = expanded else { return Ok(None) };
    let path = folder.join(&expanded);
    // A file is what its name says, even a name that could be a pattern.
    if path.exists() {
        return Ok(None);
    }
    let pattern = match FramePattern::new(&path, &[]) {
        Ok(pattern) if !pattern.has_token() => return Ok(None),
        Ok(pattern) => pattern,
        Err(error) => return Err(Diagnostic::error(span, error.to_string())),
    };
    let name = terminal::path(&pattern.folder().join(pattern.text()));
    let there = pattern
        .numbers()
        .map_err(|error| Diagnostic::error(span, format!("`{}`: its folder cannot be listed: {error}", clip(&name))))?;
    if there.is_empty() {
        let problem = format!("there is no frame of `{}`", clip(&name));
        return Err(suggest_neighbour(Diagnostic::error(span, problem), &pattern.file(shot.first)));
    }
    let (offset, outside) = (0, OutsideFrames::Error);
    let (shown, missing) = (Vec::new(), Vec::new());
    Ok(Some(FileSequence { name, span, there, pattern, shot, offset, outside, shown, missing }))
}

impl FileSequence {
    /// With what the scene says of frames: which file stands for one, and which where there is none.
    ///
    /// # Errors
    /// A shot none of whose files is there.
    pub fn timed(mut self, offset: i64, outside: OutsideFrames) -> Result<Self, Diagnostic> {
        (self.offset, self.outside) = (offset, outside);
        let [first, last] = self.ends();
        let [from, to] = self.wanted();
        // Of a loop that is not shown in full some files may be missing.
        let [begin, end] = [self.number(self.shot.first), self.number(self.shot.last)];
        let shown = match outside {
            OutsideFrames::Error if to < first || from > last => vec![],
            OutsideFrames::Loop if to - from >= last - first => vec![first..=last],
            OutsideFrames::Loop if begin > end => vec![first..=end, begin..=last],
            _ => vec![begin..=end],
        };
        let gaps = || self.there.array_windows().map(|[before, next]| before + 1..=next - 1);
        let both = |range: &RangeInclusive<i64>, gap: RangeInclusive<i64>| {
            *range.start().max(gap.start())..=*range.end().min(gap.end())
        };
        let missing = shown.iter().flat_map(|range| gaps().flat_map(|gap| both(range, gap)));
        self.missing = missing.take(MOST).collect();
        let is_shown = |number: &i64| shown.iter().any(|range| range.contains(number));
        let needed = self.there.iter().copied().filter(is_shown);
        self.shown = needed.map(|number| (number, self.reference(number))).collect();
        match self.lacking_of_shot() {
            Some(problem) if self.shown.is_empty() => Err(problem),
            _ => Ok(self),
        }
    }

    /// The numbers that the shot asks for, the first and the last, whether they are there or not.
    fn wanted(&self) -> [i64; 2] {
        [self.shot.first, self.shot.last].map(|frame| frame.saturating_add(self.offset))
    }

    /// An error about the files that the shot needs and that are not there, if any.
    pub fn lacking_of_shot(&self) -> Option<Diagnostic> {
        let [first, last] = self.ends();
        let [from, to] = self.wanted();
        let there = in_ranges(&self.there);
        let name = clip(&self.name);
        if self.outside == OutsideFrames::Error && (from < first || to > last) {
            let wanted = if from == to { format!("frame {from}") } else { format!("frames {from}-{to}") };
            let problem = format!("the shot needs {wanted} of `{name}`, and there is {there}");
            let fits = if self.shot.count() as i64 <= last - first + 1 {
                format!("frame_offset = {} begins with the first file", first - self.shot.first)
            } else {
                format!("frames = \"{}-{}\" has a file each", first - self.offset, last - self.offset)
            };
            let help = format!("{fits}; outside_frames = \"hold\" or \"loop\" shows others where there is none");
            return Some(Diagnostic::error(self.span, problem).help(help));
        }
        let one = self.missing.first()?;
        let problem = format!(
            "frame{} {} of `{name}` {} missing: there is {there}",
            if self.missing.len() == 1 { "" } else { "s" },
            in_ranges(&self.missing),
            if self.missing.len() == 1 { "is" } else { "are" },
        );
        let help = format!("write {} again, or leave it out of the frames asked for", self.file_name(*one));
        Some(Diagnostic::error(self.span, problem).help(help))
    }

    /// An error about those of some frames whose file is not there, if any.
    pub fn lacking(&self, frames: &[i64]) -> Option<Diagnostic> {
        let lacking: Vec<i64> = frames.iter().copied().filter(|frame| self.lacks(*frame)).take(MOST).collect();
        let file = self.file_name(self.unlimited(*lacking.first()?));
        let problem = format!(
            "frame{} {} show{} files of `{}` that are missing: there is {}",
            if lacking.len() == 1 { "" } else { "s" },
            in_ranges(&lacking),
            if lacking.len() == 1 { "s" } else { "" },
            clip(&self.name),
            in_ranges(&self.there),
        );
        Some(Diagnostic::error(self.span, problem).help(format!("write {file} first, or ask for other frames")))
    }

    /// Whether a frame's file is missing.
    fn lacks(&self, frame: i64) -> bool {
        self.there.binary_search(&self.unlimited(frame)).is_err()
    }

    /// The first number that there is, and the last.
    pub fn ends(&self) -> [i64; 2] {
        [self.there[0], self.there[self.there.len() - 1]]
    }

    /// How many files there are.
    pub fn count(&self) -> usize {
        self.there.len()
    }

    /// The number of the file that a frame asks for, whether it is there or not. The shot's ends hold outside of it.
    fn unlimited(&self, frame: i64) -> i64 {
        let frame = frame.clamp(self.shot.first, self.shot.last);
        match self.outside {
            OutsideFrames::Error => frame.saturating_add(self.offset),
            _ => self.number(frame),
        }
    }

    /// The number of the file that a frame of the shot shows, within those that there are.
    fn number(&self, frame: i64) -> i64 {
        let [first, last] = self.ends();
        let number = frame.saturating_add(self.offset);
        match self.outside {
            OutsideFrames::Loop => first + (number - first).rem_euclid(last - first + 1),
            _ => number.clamp(first, last),
        }
    }

    /// The file that a frame shows, with its number: between two frames that of the nearer one. Where that is missing, the next
    /// one, for what is measured over the whole shot: no frame is made of it.
    pub fn at(&self, frame: f64) -> &(i64, FileReference) {
        let frame = (frame.round() as i64).clamp(self.shot.first, self.shot.last);
        let number = self.number(frame);
        let place = self.shown.partition_point(|(known, _)| *known < number);
        &self.shown[place.min(self.shown.len() - 1)]
    }

    /// The files that the shot shows, by number.
    pub fn files(&self) -> impl Iterator<Item = &FileReference> {
        self.shown.iter().map(|(_, file)| file)
    }

    /// The numbers of those files, rising.
    pub fn numbers(&self) -> impl Iterator<Item = i64> {
        self.shown.iter().map(|(number, _)| *number)
    }

    /// Whether the shot shows more than one of them.
    pub fn varies(&self) -> bool {
        self.shown.len() > 1
    }

    fn path(&self, number: i64) -> PathBuf {
        self.pattern.file(number)
    }

    fn file_name(&self, number: i64) -> String {
        terminal::path(self.path(number).file_name().unwrap_or_default().as_ref())
    }

    fn reference(&self, number: i64) -> FileReference {
        FileReference { place: FilePlace::Disk(self.path(number)), span: self.span }
    }
}

/// Its name, what there is, and what of it is shown.
impl fmt::Display for FileSequence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = |count: usize| if count == 1 { "" } else { "s" };
        let (count, shown) = (self.count(), self.shown.len());
        write!(f, "{}: {count} file{}, {}", self.name, plural(count), in_ranges(&self.there))?;
        if shown < count {
            let numbers: Vec<i64> = self.numbers().collect();
            write!(f, "; shown are {shown}, {}", in_ranges(&numbers))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    /// Files with some numbers, for a shot.
    fn sequence(
        numbers: &[i64],
        shot: FrameRange,
        offset: i64,
        outside: OutsideFrames,
    ) -> Result<FileSequence, Diagnostic> {
        let folder = tempfile::tempdir().unwrap();
        for number in numbers {
            std::fs::write(folder.path().join(format!("m.{number:04}.vdb")), "").unwrap();
        }
        let variables: Variables = Arc::new(|_| None);
        let base = Base::Folder(folder.path().to_owned());
        let mut sequence = match find("m.$F4.vdb", Span::default(), &base, &variables, shot) {
            Ok(sequence) => sequence.unwrap(),
            Err(mut problem) => {
                problem.message = problem.message.replace(&folder.path().display().to_string(), "IN");
                return Err(problem);
            }
        };
        sequence.name = sequence.name.replace(&folder.path().display().to_string(), "IN");
        sequence.timed(offset, outside)
    }

    /// What each frame of a shot shows.
    fn found(numbers: &[i64], shot: FrameRange, offset: i64, outside: OutsideFrames) -> Result<Vec<i64>, String> {
        let sequence = sequence(numbers, shot, offset, outside).map_err(|problem| problem.message)?;
        match sequence.lacking_of_shot() {
            Some(problem) => Err(problem.message),
            None => Ok((shot.first..=shot.last).map(|frame| sequence.at(frame as f64).0).collect()),
        }
    }

    #[test]
    fn frames_have_their_files() {
        let shot = |first, last| FrameRange { first, last };
        assert_eq!(found(&[1, 2, 3, 9], shot(1, 3), 0, OutsideFrames::Error), Ok(vec![1, 2, 3]));
        assert_eq!(found(&[11, 12, 13], shot(1, 3), 10, OutsideFrames::Error), Ok(vec![11, 12, 13]));
        assert_eq!(found(&[1, 2, 3], shot(-1, 5), 0, OutsideFrames::Hold), Ok(vec![1, 1, 1, 2, 3, 3, 3]));
        assert_eq!(found(&[1, 2, 3], shot(-1, 5), 0, OutsideFrames::Loop), Ok(vec![2, 3, 1, 2, 3, 1, 2]));
        // A loop over its end, shown in part.
        assert_eq!(found(&[1, 2, 4, 5], shot(5, 7), 0, OutsideFrames::Loop), Ok(vec![5, 1, 2]));
        assert_eq!(found(&[7], shot(1, 2), 0, OutsideFrames::Hold), Ok(vec![7, 7]));
    }

    #[test]
    fn what_is_missing_is_told() {
        let shot = |first, last| FrameRange { first, last };
        let wrong = |numbers: &[i64], shot, outside| found(numbers, shot, 0, outside).unwrap_err();
        assert_eq!(
            wrong(&[1, 2, 5, 6, 8], shot(1, 8), OutsideFrames::Error),
            "frames 3-4, 7 of `IN/m.####.vdb` are missing: there is 1-2, 5-6, 8"
        );
        assert_eq!(
            wrong(&[1, 3], shot(-5, 9), OutsideFrames::Hold),
            "frame 2 of `IN/m.####.vdb` is missing: there is 1, 3"
        );
        assert_eq!(
            wrong(&[1, 2], shot(1, 3), OutsideFrames::Error),
            "the shot needs frames 1-3 of `IN/m.####.vdb`, and there is 1-2"
        );
        assert_eq!(wrong(&[], shot(1, 3), OutsideFrames::Error), "there is no frame of `IN/m.####.vdb`");
        // A shot of any length is told at once.
        assert_eq!(
            wrong(&[1, 999_999_999], shot(1, 999_999_999), OutsideFrames::Error).len(),
            "frames 2-101 of `IN/m.####.vdb` are missing: there is 1, 999999999".len()
        );
    }

    #[test]
    fn frames_need_their_own_files_only() {
        let shot = FrameRange { first: 1, last: 9 };
        let lacking = |sequence: &FileSequence, frames: &[i64]| sequence.lacking(frames).map(|problem| problem.message);
        let files = sequence(&[11, 12, 15, 16, 18], shot, 10, OutsideFrames::Error).unwrap();
        assert_eq!(lacking(&files, &[1, 2, 5, 6, 8]), None);
        assert_eq!(lacking(&files, &[-7]), None, "the shot's first frame holds before it");
        assert_eq!(
            lacking(&files, &[1, 3, 4, 7, 8, 9, 20]).unwrap(),
            "frames 3-4, 7, 9, 20 show files of `IN/m.####.vdb` that are missing: there is 11-12, 15-16, 18"
        );
        assert!(lacking(&files, &[7]).unwrap().starts_with("frame 7 shows files of"));
        // What is measured over the shot takes those that there are.
        assert_eq!([1.0, 3.0, 4.0, 7.0, 9.0].map(|frame| files.at(frame).0), [11, 15, 15, 18, 18]);
        assert_eq!(files.numbers().collect::<Vec<_>>(), [11, 12, 15, 16, 18]);
        let held = sequence(&[2, 3, 5], shot, 0, OutsideFrames::Hold).unwrap();
        assert_eq!(lacking(&held, &[1, 2, 3, 5, 9]), None);
        assert!(lacking(&held, &[4]).is_some());
        assert!(sequence(&[10, 11], shot, 0, OutsideFrames::Error).is_err());
        assert!(sequence(&[0, 10], shot, 0, OutsideFrames::Error).is_err());
    }
}
