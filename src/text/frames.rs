//! Frames and the shot: which frames there are, and what time each stands for.

use std::fmt;
use std::num::IntErrorKind;
use std::str::FromStr;
use std::sync::Arc;

use crate::text::moment::Moment;

/// Frames from a first to a last one, both included, `first ≤ last`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    /// The first.
    pub first: i64,
    /// The last.
    pub last: i64,
}

/// The last frame there is: nine digits, as many as file names and metadata hold.
pub const MOST_FRAME: i64 = 999_999_999;

/// Why a text is no range of frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BadRange {
    /// It is no number, and no two with a hyphen between.
    NoNumbers,
    /// Its last frame is before its first.
    Backwards,
    /// A frame has more than nine digits, which neither file names nor metadata hold.
    TooLarge,
}

impl fmt::Display for BadRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoNumbers => "is no frame number or range",
            Self::Backwards => "runs backwards",
            Self::TooLarge => "has a frame of more than nine digits",
        })
    }
}

impl std::error::Error for BadRange {}

impl FromStr for FrameRange {
    type Err = BadRange;

    /// Reads `"1-48"`, `"-5-10"` or `"7"`.
    fn from_str(text: &str) -> Result<Self, BadRange> {
        let text = text.trim();
        // A minus sign in front belongs to the number; the next one divides first from last.
        let divider = text.char_indices().skip(1).find(|&(_, c)| c == '-').map(|(at, _)| at);
        let number = |text: &str| match text.trim().parse::<i64>() {
            Ok(frame) if (-MOST_FRAME..=MOST_FRAME).contains(&frame) => Ok(frame),
            Ok(_) => Err(BadRange::TooLarge),
            Err(error) => match error.kind() {
                IntErrorKind::PosOverflow | IntErrorKind::NegOverflow => Err(BadRange::TooLarge),
                _ => Err(BadRange::NoNumbers),
            },
        };
        let (first, last) = match divider {
            Some(at) => (number(&text[..at])?, number(&text[at + 1..])?),
            None => (number(text)?, number(text)?),
        };
        if first <= last { Ok(Self { first, last }) } else { Err(BadRange::Backwards) }
    }
}

impl FrameRange {
    /// How many there are.
    pub fn count(self) -> usize {
        (self.last - self.first + 1) as usize
    }

    /// Where a frame lies between the first (0) and the last (1), held outside. 0 where there is only one.
    pub fn share(self, frame: f64) -> f64 {
        if self.first == self.last {
            return 0.0;
        }
        ((frame - self.first as f64) / (self.last - self.first) as f64).clamp(0.0, 1.0)
    }
}

/// The shot: a scene's own frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// Its frames; frame 1 alone for a still.
    pub range: FrameRange,
    /// Frames a second.
    pub fps: f64,
    /// Whether the scene names no frames: t = 0 for any frame.
    pub still: bool,
}

impl Shot {
    /// The moment of a frame. Outside the shot the ends hold.
    pub fn moment(&self, frame: f64, parameters: Arc<[f64]>) -> Moment {
        let (first, last) = (self.range.first as f64, self.range.last as f64);
        let frame = frame.clamp(first, last);
        Moment { t: self.range.share(frame), frame, time: (frame - first) / self.fps, parameters }
    }

    /// The frame, mostly between two, at a time t from 0 to 1.
    pub fn frame_at(&self, t: f64) -> f64 {
        let (first, last) = (self.range.first as f64, self.range.last as f64);
        first + (last - first) * t
    }
}

/// A frame as people write it: without a fraction where it has none.
pub fn plain(frame: f64) -> String {
    let text = format!("{frame:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Frames, rising, as people write them: `2-5, 9`; long lists are cut.
pub fn in_ranges(frames: &[i64]) -> String {
    /// The most ranges that are written.
    const MOST: usize = 8;
    let ranges: Vec<&[i64]> = frames.chunk_by(|a, b| *b == a + 1).collect();
    let written: Vec<String> = ranges
        .iter()
        .take(MOST)
        .map(|range| match range {
            [only] => only.to_string(),
            _ => format!("{}-{}", range[0], range[range.len() - 1]),
        })
        .collect();
    let left: usize = ranges.iter().skip(MOST).map(|range| range.len()).sum();
    let more = if left > 0 { format!(" and {left} more") } else { String::new() };
    written.join(", ") + &more
}

/// The most frames at which the box of a shape that changes is taken; more frames are sampled evenly.
const MOST_BOXES: usize = 200;

/// All frames of a range, or as many as are looked at, evenly, with both ends.
pub(crate) fn sampled_frames(range: FrameRange) -> Vec<f64> {
    let FrameRange { first, last } = range;
    if range.count() <= MOST_BOXES {
        return (first..=last).map(|frame| frame as f64).collect();
    }
    (0..MOST_BOXES).map(|i| first as f64 + (last - first) as f64 * (i as f64 / (MOST_BOXES - 1) as f64)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_read_with_signs() {
        let range = |first, last| Ok(FrameRange { first, last });
        assert_eq!("1-48".parse(), range(1, 48));
        assert_eq!(" 1001 - 1096 ".parse(), range(1001, 1096));
        assert_eq!("7".parse(), range(7, 7));
        assert_eq!("-7".parse(), range(-7, -7));
        assert_eq!("-7--2".parse(), range(-7, -2));
        assert_eq!("-5-10".parse(), range(-5, 10));
        for bad in ["", "-", "a", "1-48x2", "1-", "1..3"] {
            assert_eq!(bad.parse::<FrameRange>(), Err(BadRange::NoNumbers), "{bad}");
        }
        assert_eq!("48-1".parse::<FrameRange>(), Err(BadRange::Backwards));
        for bad in ["1-1000000000", "-1000000000", "99999999999999999999-1"] {
            assert_eq!(bad.parse::<FrameRange>(), Err(BadRange::TooLarge), "{bad}");
        }
    }

    #[test]
    fn frames_in_a_row_are_told_as_ranges() {
        assert_eq!(in_ranges(&[1, 2, 3, 5, 8, 9]), "1-3, 5, 8-9");
        assert_eq!(in_ranges(&[-2]), "-2");
        let odd: Vec<i64> = (0..40).map(|i| 2 * i).collect();
        assert_eq!(in_ranges(&odd), "0, 2, 4, 6, 8, 10, 12, 14 and 32 more");
    }

    #[test]
    fn time_runs_over_the_shot_and_holds_outside() {
        let shot = Shot { range: FrameRange { first: 1001, last: 1025 }, fps: 24.0, still: false };
        let at = |frame: f64| shot.moment(frame, Arc::new([]));
        assert_eq!((at(1001.0).t, at(1001.0).time), (0.0, 0.0));
        assert_eq!((at(1025.0).t, at(1025.0).time), (1.0, 1.0));
        assert_eq!(at(1013.0).t, 0.5);
        assert_eq!((at(990.0).t, at(990.0).frame), (0.0, 1001.0));
        assert_eq!((at(2000.0).t, at(2000.0).frame), (1.0, 1025.0));
        assert_eq!(shot.frame_at(0.5), 1013.0);
        let one = Shot { range: FrameRange { first: 5, last: 5 }, fps: 24.0, still: true };
        assert_eq!(one.moment(5.0, Arc::new([])).t, 0.0);
    }
}
