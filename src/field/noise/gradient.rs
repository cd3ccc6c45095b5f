//! Gradient noise: a slope at each corner of the cells, where the value is one half, and smoothly from one to the next.
//!
//! Perlin, Improving noise, SIGGRAPH 2002, with unit directions.

use glam::DVec3;

use super::hash::{direction, of_cell};
use super::{Noise, cell_of, corners};

/// Gradient noise.
#[derive(Clone, Copy, Debug)]
pub struct GradientNoise {
    /// What it starts from.
    pub seed: u64,
}

/// The most that the sum of unit slopes comes to, in the middle of a cell: half of its diagonal.
const MOST: f64 = 0.866_025_403_784_438_6;

impl Noise for GradientNoise {
    fn at(&self, position: DVec3) -> (f64, DVec3) {
        let Some((cell, within)) = cell_of(position) else { return (f64::NAN, DVec3::NAN) };
        let (mut value, mut slope) = (0.0, DVec3::ZERO);
        for (by, weight, slopes) in corners(within) {
            let way = direction(of_cell(cell + by, self.seed));
            let height = way.dot(within - by.as_dvec3());
            value += height * weight;
            slope += way * weight + height * slopes;
        }
        ((0.5 + value / (2.0 * MOST)).clamp(0.0, 1.0), slope / (2.0 * MOST))
    }

    /// Of Σ wᵢ·gᵢ·dᵢ the slopes gᵢ make a mean of length 1 at most; the weights' slopes make, along each axis, no more than
    /// 15/8·(|d₀| + |d₁|), whose mean over the other axes is √3 at most, in the middle.
    fn steepest(&self) -> f64 {
        (1.0 + 3.0_f64.sqrt() * 1.875 * 3.0_f64.sqrt()) / (2.0 * MOST)
    }
}
