//! Which frames: the text of `--frames` and `--shot`.

use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

/// More frames than this in one call are taken for a mistake.
const MOST_FRAMES: u64 = 1_000_000;

/// A set of frame numbers, ascending, none twice, never empty.
///
/// Written `7`, `1-48`, every fourth of them `1-48x4` or `1-48:4`, and lists of these with commas.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frames(Vec<i64>);

impl Frames {
    /// All frames from `first` to `last`, both included; `first ≤ last`.
    pub fn range(first: i64, last: i64) -> Self {
        Self((first..=last).collect())
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

impl FromStr for Frames {
    type Err = FramesError;

    fn from_str(text: &str) -> Result<Self, FramesError> {
        let mut numbers = BTreeSet::new();
        for part in text.split(',') {
            let (first, last, step) = parse_part(part.trim())?;
            let count = last.abs_diff(first) / step + 1;
            if count > MOST_FRAMES || numbers.len() as u64 > MOST_FRAMES {
                return Err(FramesError(format!("\"{text}\" means more than {MOST_FRAMES} frames")));
            }
            let mut frame = Some(first);
            while let Some(number) = frame.filter(|&number| number <= last) {
                numbers.insert(number);
                frame = i64::try_from(step).ok().and_then(|step| number.checked_add(step));
            }
        }
        Ok(Self(numbers.into_iter().collect()))
    }
}

/// `7`, `1-48`, `1-48x4`: first, last, step.
fn parse_part(part: &str) -> Result<(i64, i64, u64), FramesError> {
    let wrong = |why: &str| FramesError(format!("\"{part}\" {why}"));
    let (range, step) = match part.split_once(['x', ':']) {
        Some((range, step)) => {
            let step = step.parse::<u64>().map_err(|_| wrong("has no whole number as its step"))?;
            (range, step)
        }
        None => (part, 1),
    };
    if step == 0 {
        return Err(wrong("has a step of 0"));
    }
    // A minus sign in front belongs to the number; the next one divides first from last.
    let divider = range.char_indices().skip(1).find(|&(_, c)| c == '-').map(|(at, _)| at);
    let number = |text: &str| text.parse::<i64>().map_err(|_| wrong("is no frame number or range"));
    let (first, last) = match divider {
        Some(at) => (number(&range[..at])?, number(&range[at + 1..])?),
        None => {
            let only = number(range)?;
            (only, only)
        }
    };
    if last < first {
        return Err(wrong("runs backwards"));
    }
    Ok((first, last, step))
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
            ("1-999999999999", "more than 1000000 frames"),
            ("9223372036854775807-9223372036854775807x9", ""),
        ] {
            match text.parse::<Frames>() {
                Ok(frames) => assert!(why.is_empty() && frames.numbers().len() == 1, "{text}"),
                Err(error) => assert!(!why.is_empty() && error.to_string().contains(why), "{text}: {error}"),
            }
        }
    }
}
