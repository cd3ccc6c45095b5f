//! The name of a frame's file: a path with at most one frame token, `####`, `%04d` or `$F4`.

use crate::terminal;
use std::fmt;
use std::path::{Path, PathBuf};

/// A path that becomes one file for each frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FramePattern {
    folder: PathBuf,
    before: String,
    /// Least number of digits, or `None` where the name has no frame token.
    digits: Option<usize>,
    after: String,
}

/// Why a path is no frame pattern. Each is a wrong command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PatternError {
    /// The path ends in no file name, or in one that is not UTF-8.
    NoName(PathBuf),
    /// The name does not end in one of the extensions asked for.
    Extension(PathBuf, Vec<&'static str>),
    /// More than one frame token.
    TwoTokens(PathBuf),
    /// A frame token in a folder's name.
    TokenInFolder(PathBuf),
    /// Several frames, but no token to tell them apart.
    NoToken(PathBuf, usize),
    /// A token that other programs would fill with spaces: the token, and one that fills with zeros.
    Spaces(PathBuf, String, String),
    /// A token of more digits than any frame has.
    Wide(PathBuf, String),
}

impl fmt::Display for PatternError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoName(path) => {
                write!(f, "{}: this is no file name; write one such as out/name.####.vdb", terminal::path(path))
            }
            Self::Extension(path, extensions) => write!(
                f,
                "{}: the name must end in .{}, as in name.####.{}",
                terminal::path(path),
                extensions.join(" or ."),
                extensions.first().unwrap_or(&"")
            ),
            Self::TwoTokens(path) => {
                write!(
                    f,
                    "{}: the name has more than one frame token; leave one of ####, %04d, $F4",
                    terminal::path(path)
                )
            }
            Self::TokenInFolder(path) => {
                write!(
                    f,
                    "{}: a frame token may stand in the file's name only, not in a folder's",
                    terminal::path(path)
                )
            }
            Self::Spaces(path, token, zeros) => write!(
                f,
                "{}: {token} fills the number with spaces, which no program finds again; write {zeros}",
                terminal::path(path)
            ),
            Self::Wide(path, token) => {
                write!(f, "{}: {token} is for more than {MOST_DIGITS} digits; write %04d", terminal::path(path))
            }
            Self::NoToken(path, frames) => write!(
                f,
                "{}: {frames} frames would go into one file; put a frame token into the name, as in name.####.{} \
                 (the shell may have eaten $F4: quote it)",
                terminal::path(path),
                terminal::path(path.extension().unwrap_or_default().as_ref())
            ),
        }
    }
}

impl std::error::Error for PatternError {}

impl FramePattern {
    /// Reads a path whose name must end in one of the extensions, where there are any.
    pub fn new(path: &Path, extensions: &[&'static str]) -> Result<Self, PatternError> {
        let name = path.file_name().and_then(|name| name.to_str()).ok_or_else(|| PatternError::NoName(path.into()))?;
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        if folder.to_str().is_some_and(|folder| find_token(folder).is_some()) {
            return Err(PatternError::TokenInFolder(path.into()));
        }
        // A name that is nothing but `.vdb` has no extension.
        let end = Path::new(name).extension().unwrap_or_default();
        if !extensions.is_empty() && !extensions.iter().any(|extension| end.eq_ignore_ascii_case(extension)) {
            return Err(PatternError::Extension(path.into(), extensions.into()));
        }
        let Some((start, end, digits)) = find_token(name) else {
            return Ok(Self { folder, before: name.into(), digits: None, after: String::new() });
        };
        let token = &name[start..end];
        if digits > MOST_DIGITS {
            return Err(PatternError::Wide(path.into(), token.into()));
        }
        if let Some(width) = token.strip_prefix('%').filter(|width| !(width.starts_with('0') || *width == "d")) {
            return Err(PatternError::Spaces(path.into(), token.into(), format!("%0{width}")));
        }
        let (before, after) = (&name[..start], &name[end..]);
        if find_token(after).is_some() {
            return Err(PatternError::TwoTokens(path.into()));
        }
        Ok(Self { folder, before: before.into(), digits: Some(digits), after: after.into() })
    }

    /// The folder the files go to; empty for the current one.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// An error where several frames would go into one file.
    pub fn holds(&self, frames: usize) -> Result<(), PatternError> {
        if frames > 1 && self.digits.is_none() {
            return Err(PatternError::NoToken(self.folder.join(&self.before), frames));
        }
        Ok(())
    }

    /// Whether each frame has a file of its own.
    pub fn has_token(&self) -> bool {
        self.digits.is_some()
    }

    /// The file of one frame.
    pub fn file(&self, frame: i64) -> PathBuf {
        match self.digits {
            Some(digits) => self.folder.join(format!("{}{frame:0digits$}{}", self.before, self.after)),
            None => self.folder.join(&self.before),
        }
    }

    /// The pattern without its folder, such as `m.####.vdb`: the same for the three ways to write a token.
    pub fn text(&self) -> String {
        format!("{}{}{}", self.before, "#".repeat(self.digits.unwrap_or(0)), self.after)
    }

    /// The sequence's name: the file's without frame token and extension, and without what divides them.
    pub fn name(&self) -> String {
        let whole = format!("{}{}", self.before.trim_end_matches(['.', '_', '-']), self.after);
        let stem = Path::new(&whole).file_stem().and_then(|stem| stem.to_str()).unwrap_or(&whole);
        // Nothing but a frame token and an extension is left of `####.vdb`.
        if stem.starts_with('.') || stem.is_empty() { "frames".into() } else { stem.into() }
    }

    /// The frame whose file has this name, without a folder. A name without a frame token is that of any frame: 0.
    pub fn frame_of(&self, name: &str) -> Option<i64> {
        let frame = match self.digits {
            Some(_) => name.strip_prefix(&self.before)?.strip_suffix(&self.after)?.parse().ok()?,
            None => 0,
        };
        (self.file(frame).file_name()?.to_str()? == name).then_some(frame)
    }

    /// The frames whose files are there, rising.
    ///
    /// # Errors
    /// Why the folder cannot be listed.
    pub fn numbers(&self) -> std::io::Result<Vec<i64>> {
        let folder = if self.folder.as_os_str().is_empty() { Path::new(".") } else { &self.folder };
        let mut numbers = Vec::new();
        for entry in std::fs::read_dir(folder)? {
            // Names that are not UTF-8 are those of other files.
            numbers.extend(entry?.file_name().to_str().and_then(|name| self.frame_of(name)));
        }
        numbers.sort_unstable();
        Ok(numbers)
    }

    /// Whether Blender and others will see a sequence: they read the last run of digits before the extension.
    pub fn number_is_last(&self) -> bool {
        let after = self.after.rsplit_once('.').map_or("", |(after, _)| after);
        self.digits.is_none() || !after.contains(|c: char| c.is_alphanumeric())
    }
}

/// The first frame token: where it starts and ends, and its least number of digits.
fn find_token(text: &str) -> Option<(usize, usize, usize)> {
    let bytes = text.as_bytes();
    for start in 0..bytes.len() {
        let rest = &text.get(start..).unwrap_or("");
        let run = |from: usize, f: fn(u8) -> bool| rest.bytes().skip(from).take_while(|&b| f(b)).count();
        match bytes[start] {
            b'#' => {
                let hashes = run(0, |b| b == b'#');
                return Some((start, start + hashes, hashes));
            }
            b'%' => {
                let digits = run(1, |b| b.is_ascii_digit());
                if rest.as_bytes().get(1 + digits) == Some(&b'd') {
                    return Some((start, start + digits + 2, width(&rest[1..=digits])));
                }
            }
            b'$' if rest.as_bytes().get(1) == Some(&b'F') => {
                let digits = run(2, |b| b.is_ascii_digit());
                return Some((start, start + 2 + digits, width(&rest[2..2 + digits])));
            }
            _ => {}
        }
    }
    None
}

/// The most digits of a token: twice as many as the largest frame has. File names are 255 bytes long at most.
const MOST_DIGITS: usize = 20;

/// A token's number of digits, without a number 1; however many it asks for.
fn width(digits: &str) -> usize {
    if digits.is_empty() { 1 } else { digits.parse().map_or(usize::MAX, |digits: usize| digits.max(1)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(pattern: &str, frame: i64) -> String {
        FramePattern::new(Path::new(pattern), &["vdb"]).unwrap().file(frame).display().to_string()
    }

    #[test]
    fn the_three_tokens() {
        assert_eq!(file("out/m.####.vdb", 7), "out/m.0007.vdb");
        assert_eq!(file("m_%04d.vdb", 12345), "m_12345.vdb");
        assert_eq!(file("m%d.vdb", 3), "m3.vdb");
        assert_eq!(file("m.$F4.vdb", 12), "m.0012.vdb");
        assert_eq!(file("m.$F.vdb", 12), "m.12.vdb");
        assert_eq!(file("still.vdb", 12), "still.vdb");
        assert_eq!(file("100%.vdb", 1), "100%.vdb");
        assert_eq!(file("größe.##.vdb", 1), "größe.01.vdb");
    }

    #[test]
    fn wrong_patterns() {
        let wrong = |pattern: &str| FramePattern::new(Path::new(pattern), &["vdb"]).unwrap_err();
        assert!(matches!(wrong("m.####.png"), PatternError::Extension(..)));
        assert!(matches!(wrong(".vdb"), PatternError::Extension(..)));
        assert!(matches!(wrong("m.##.$F4.vdb"), PatternError::TwoTokens(_)));
        assert!(matches!(wrong("s.##/m.vdb"), PatternError::TokenInFolder(_)));
        assert!(matches!(wrong("out/.."), PatternError::NoName(_)));
        for spaces in ["m.%4d.vdb", "m.%12d.vdb"] {
            assert!(matches!(wrong(spaces), PatternError::Spaces(..)), "{spaces}");
        }
        assert!(wrong("m.%4d.vdb").to_string().contains("write %04d"));
        for wide in ["m.%0100d.vdb", "m.$F21.vdb", "m.#####################.vdb", "m.%099999999999999999999d.vdb"] {
            assert!(matches!(wrong(wide), PatternError::Wide(..)), "{wide}");
        }
        assert_eq!(file("m.%020d.vdb", 1), format!("m.{}1.vdb", "0".repeat(19)));
        let still = FramePattern::new(Path::new("m.vdb"), &["vdb"]).unwrap();
        assert!(still.holds(1).is_ok() && still.holds(2).is_err());
    }

    #[test]
    fn names_of_sequences_and_their_files() {
        let pattern = |text: &str| FramePattern::new(Path::new(text), &["vdb"]).unwrap();
        for (text, name) in [
            ("out/m.####.vdb", "m"),
            ("m_%04d.vdb", "m"),
            ("m.vdb", "m"),
            ("shot.v2.$F4.vdb", "shot.v2"),
            ("m.####.left.vdb", "m.left"),
            ("####.vdb", "frames"),
        ] {
            assert_eq!(pattern(text).name(), name, "{text}");
        }
        let m = pattern("out/m.$F4.vdb");
        assert_eq!(m.text(), "m.####.vdb");
        for frame in [-7, 0, 7, 12345] {
            assert_eq!(m.frame_of(m.file(frame).file_name().unwrap().to_str().unwrap()), Some(frame));
        }
        for other in ["m.007.vdb", "m.00007.vdb", "m.+007.vdb", "n.0007.vdb", "m.0007.png", "m..vdb"] {
            assert_eq!(m.frame_of(other), None, "{other}");
        }
        assert_eq!((pattern("m.vdb").frame_of("m.vdb"), pattern("m.vdb").frame_of("n.vdb")), (Some(0), None));
    }

    #[test]
    fn a_number_that_is_not_last_is_noticed() {
        let last = |pattern: &str| FramePattern::new(Path::new(pattern), &["vdb"]).unwrap().number_is_last();
        assert!(last("m_####.vdb") && last("m.####.VDB") && last("still.vdb"));
        assert!(!last("m_####_v2.vdb"));
    }
}
