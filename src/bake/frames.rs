//! Which frames: the text of `--frames` and `--shot`.

use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

use crate::text::{BadRange, FrameRange};

/// More frames than this in one call are taken for a mistake.
const MOST_FRAMES: u64 = 1_000_000;

/// A set of frame numbers, ascending, none twice, never empty.
///
/// Written `7`, `1-48`, every fourth of them `1-48x4` or `1-48:4`, and lists of these with commas.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frames(Vec<i64>);

impl Frames {
    /// All frames of a range, or why they are too many.
    pub fn of_range(range: FrameRange) -> Result<Self, FramesError> {
        if range.count() as u64 > MOST_FRAMES {
            return Err(too_many(&format!("{}-{}", range.first, range.last)));
        }
        Ok(Self((range.first..=range.last).collect()))
    }

    /// These frames; `None` where there are none.
    pub fn of_numbers(numbers: impl IntoIterator<Item = i64>) -> Option<Self> {
        let numbers: BTreeSet<i64> = numbers.into_iter().collect();
        (!numbers.is_empty()).then(|| Self(numbers.into_iter().collect()))
    }

    /// The numbers, ascending.
    pub fn numbers(&self) -> &[i64] {
        &self.0
    }

    /// The first and the last.
    pub fn ends(&self) -> (i64, i64) {
        (self.0[0], self.0[self.0.len() - 1])
    }
}

/// Why a text is no set of frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FramesError(String);

impl fmt::Display for FramesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; write frames as 7, 1-48, 1-48x4 or 1-48:4 (every fourth), or lists of these: 7,9,12-20", self.0)
    }
}

impl std::error::Error for FramesError {}

impl fmt::Display for Frames {
    /// As ranges, short, and such that it is read as the same frames: `1-48,50`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let range = |range: &[i64]| match range {
            [only] => only.to_string(),
            _ => format!("{}-{}", range[0], range[range.len() - 1]),
        };
        let ranges: Vec<_> = self.0.chunk_by(|a, b| *b == a + 1).map(range).collect();
        f.write_str(&ranges.join(","))
    }
}

impl FromStr for Frames {
    type Err = FramesError;

    fn from_str(text: &str) -> Result<Self, FramesError> {
        let mut numbers = BTreeSet::new();
        for part in text.split(',') {
            let (range, step) = parse_part(part.trim())?;
            numbers.extend((range.first..=range.last).step_by(step).take(MOST_FRAMES as usize + 1));
            if numbers.len() as u64 > MOST_FRAMES {
                return Err(too_many(text));
            }
        }
        Ok(Self(numbers.into_iter().collect()))
    }
}

fn too_many(text: &str) -> FramesError {
    FramesError(format!("\"{text}\" means more than {MOST_FRAMES} frames"))
}

/// `7`, `1-48`, `1-48x4`: the range, the step.
fn parse_part(part: &str) -> Result<(FrameRange, usize), FramesError> {
    let wrong = |why: &str| FramesError(format!("\"{part}\" {why}"));
    let (range, step) = match part.split_once(['x', ':']) {
        Some((range, step)) => (range, step.parse().map_err(|_| wrong("has no whole number as its step"))?),
        None => (part, 1),
    };
    if step == 0 {
        return Err(wrong("has a step of 0"));
    }
    let range = range.parse().map_err(|bad: BadRange| wrong(&bad.to_string()))?;
    Ok((range, step))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(text: &str) -> Vec<i64> {
        text.parse::<Frames>().unwrap().numbers().to_vec()
    }

    #[test]
    fn single_ranges_steps_and_lists() {
        assert_eq!(numbers("7"), [7]);
        assert_eq!(numbers("7-7"), [7]);
        assert_eq!(numbers("1-10x4"), [1, 5, 9]);
        assert_eq!(numbers("1-10:3"), [1, 4, 7, 10]);
        assert_eq!(numbers("7,9, 12-14,13"), [7, 9, 12, 13, 14]);
        assert_eq!(numbers("-3--1"), [-3, -2, -1]);
        assert_eq!(numbers("-1-1"), [-1, 0, 1]);
    }

    #[test]
    fn wrong_texts_say_what_is_wrong() {
        for (text, why) in [
            ("", "is no frame number"),
            ("a", "is no frame number"),
            ("5-1", "runs backwards"),
            ("1-5x0", "a step of 0"),
            ("1-5x", "no whole number as its step"),
            ("1-999999999", "more than 1000000 frames"),
            ("1-1000000,2000000-2000001", "more than 1000000 frames"),
            ("1000000000", "a frame of more than nine digits"),
            ("1-9223372036854775808", "a frame of more than nine digits"),
        ] {
            let error = text.parse::<Frames>().expect_err(text).to_string();
            assert!(error.contains(why), "{text}: {error}");
        }
        assert_eq!(numbers("1-999999999x999999998"), [1, 999_999_999]);
    }

    #[test]
    fn printed_frames_are_read_as_the_same() {
        for text in ["7", "1-48", "1-3,5,9-12", "-3--1,4"] {
            assert_eq!(text.parse::<Frames>().unwrap().to_string(), text);
        }
        let every_fourth: Frames = "1-96x4".parse().unwrap();
        assert_eq!(every_fourth.to_string().parse(), Ok(every_fourth));
    }
}
