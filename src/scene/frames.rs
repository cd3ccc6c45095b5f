//! Frames and the shot: which frames there are, and what time each stands for.

use std::sync::Arc;

use super::number::Moment;

/// Frames from a first to a last one, both included, `first ≤ last`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    /// The first.
    pub first: i64,
    /// The last.
    pub last: i64,
}

impl FrameRange {
    /// Reads `"1-48"`, `"-5-10"` or `"7"`.
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        if let Ok(only) = text.parse() {
            return Self { first: only, last: only }.checked();
        }
        // The first hyphen may be a sign.
        let hyphen = text.char_indices().skip(1).find(|&(_, c)| c == '-')?.0;
        let (first, last) = (text[..hyphen].trim().parse().ok()?, text[hyphen + 1..].trim().parse().ok()?);
        Self { first, last }.checked()
    }

    /// Numbers that frames can have: those that fit in file names and in exact `f64`.
    fn checked(self) -> Option<Self> {
        const MOST: i64 = 999_999_999;
        let fits = |frame: i64| (-MOST..=MOST).contains(&frame);
        (fits(self.first) && fits(self.last) && self.first <= self.last).then_some(self)
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_read_with_signs() {
        let range = |first, last| Some(FrameRange { first, last });
        assert_eq!(FrameRange::parse("1-48"), range(1, 48));
        assert_eq!(FrameRange::parse(" 1001 - 1096 "), range(1001, 1096));
        assert_eq!(FrameRange::parse("7"), range(7, 7));
        assert_eq!(FrameRange::parse("-7"), range(-7, -7));
        assert_eq!(FrameRange::parse("-7--2"), range(-7, -2));
        assert_eq!(FrameRange::parse("-5-10"), range(-5, 10));
        for bad in ["", "-", "a", "48-1", "1-48x2", "1-", "1..3", "99999999999-99999999999"] {
            assert_eq!(FrameRange::parse(bad), None, "{bad}");
        }
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
