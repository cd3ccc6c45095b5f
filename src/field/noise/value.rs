//! Value noise: a number at each corner of the cells, and smoothly from one to the next.

use glam::DVec3;

use super::hash::{of_cell, share};
use super::{Noise, cell_of, corners};

/// Value noise.
#[derive(Clone, Copy, Debug)]
pub struct ValueNoise {
    /// What it starts from.
    pub seed: u64,
}

impl Noise for ValueNoise {
    fn at(&self, position: DVec3) -> (f64, DVec3) {
        let Some((cell, within)) = cell_of(position) else { return (f64::NAN, DVec3::NAN) };
        let (mut value, mut slope) = (0.0, DVec3::ZERO);
        for (by, weight, slopes) in corners(within) {
            let number = share(of_cell(cell + by, self.seed));
            value += number * weight;
            slope += number * slopes;
        }
        (value.clamp(0.0, 1.0), slope)
    }

    /// The slope of the fade, 15/8, along each axis.
    fn steepest(&self) -> f64 {
        1.875 * 3.0_f64.sqrt()
    }
}
