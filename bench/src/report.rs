//! Results in lines that people read and `scripts/performance.py` reads too.
//!
//! `ROW number scene resolution what median low high goal words`: the number of the goal, the scene and voxels
//! along the box, what was measured (`clock` and `processor` are ratios of times), its median and the borders of its
//! middle half, and the goal, `≥ 3`, `≤ 0.8` or `-`.

use std::fmt;

use super::clock::{CLOCKS, Seconds, quartiles};

/// What a ratio shall be. It also says which ratio: how many times as fast as the rival, or which share of its time.
#[derive(Clone, Copy)]
pub enum Goal {
    /// The rival's time in ours.
    AtLeast(f64),
    /// Our time in the rival's.
    AtMost(f64),
    /// The rival's time in ours, of which nothing is demanded.
    None,
}

impl fmt::Display for Goal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtLeast(goal) => write!(f, "≥ {goal}"),
            Self::AtMost(goal) => write!(f, "≤ {goal}"),
            Self::None => f.write_str("-"),
        }
    }
}

/// A number with as many digits as anyone wants.
fn in_digits(value: f64) -> String {
    if value != 0.0 && value.abs() < 0.01 { format!("{value:.1e}") } else { format!("{value:.3}") }
}

/// What is measured: the goal's number in the table of goals, a scene, voxels along its box.
#[derive(Clone, Copy)]
pub struct Row<'a>(pub &'a str, pub &'a str, pub u32);

impl Row<'_> {
    /// Prints a number with its spread.
    pub fn spread(&self, what: &str, [median, low, high]: [f64; 3], goal: Goal) {
        let Self(number, scene, resolution) = self;
        let [median, low, high] = [median, low, high].map(in_digits);
        println!("ROW {number} {scene} {resolution} {what} {median} {low} {high} goal {goal}");
    }

    /// Prints a number that has none.
    pub fn value(&self, what: &str, value: f64, goal: Goal) {
        self.spread(what, [value; 3], goal);
    }

    /// Prints ratios pair by pair, by the clock and of processor time.
    pub fn compare(&self, title: &str, goal: Goal, pairs: &[[Seconds; 2]]) {
        let Self(number, scene, resolution) = self;
        println!("{scene} at {resolution}: {title} (goal {number}: {goal}), {} pairs", pairs.len());
        for (clock, name) in CLOCKS.into_iter().enumerate() {
            let [ours, theirs] = [0, 1].map(|side| 1e3 * quartiles(pairs.iter().map(|pair| pair[side][clock]))[0]);
            println!("    {name}: {ours:.1} ms against {theirs:.1} ms");
            let ratio = |[ours, theirs]: &[Seconds; 2]| match goal {
                Goal::AtMost(_) => ours[clock] / theirs[clock],
                Goal::AtLeast(_) | Goal::None => theirs[clock] / ours[clock],
            };
            self.spread(name, quartiles(pairs.iter().map(ratio)), goal);
        }
    }
}
