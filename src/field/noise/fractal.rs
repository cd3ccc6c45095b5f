//! Sums of gradient noise of ever finer cells: each octave half as large and half as strong as the one before.
//!
//! Musgrave, in Ebert and others, Texturing and Modeling: A Procedural Approach: fractional Brownian motion, turbulence, and
//! ridges.

use glam::DVec3;

use super::{GradientNoise, Noise};
use crate::field::{Aabb, Interval};

/// What is summed of noise n from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fold {
    /// n itself.
    Plain,
    /// 1 − |2n − 1|: crests where it is one half.
    Ridged,
    /// |2n − 1|: valleys there.
    Turbulence,
}

/// A sum of octaves.
#[derive(Clone, Copy, Debug)]
pub struct Fractal {
    /// What it starts from.
    pub seed: u64,
    /// How many.
    pub octaves: u32,
    /// What is summed.
    pub fold: Fold,
}

/// More are finer than any voxel.
pub const MOST_OCTAVES: u32 = 16;

impl Fractal {
    /// Each octave: its noise, where that is read at the origin, its scale and its share. Their cells do not meet in one corner.
    fn each(&self, mut visit: impl FnMut(GradientNoise, DVec3, f64, f64)) {
        let octaves = self.octaves.clamp(1, MOST_OCTAVES);
        // 1 + 1/2 + …
        let whole = 2.0 - 0.5_f64.powi(octaves as i32 - 1);
        let (mut scale, mut share) = (1.0, 1.0 / whole);
        for octave in 0..octaves {
            let shift = DVec3::new(17.28, 5.47, 11.91) * f64::from(octave);
            visit(GradientNoise { seed: self.seed.wrapping_add(u64::from(octave)) }, shift, scale, share);
            scale *= 2.0;
            share *= 0.5;
        }
    }
}

impl Noise for Fractal {
    fn at(&self, position: DVec3) -> (f64, DVec3) {
        let (mut value, mut slope) = (0.0, DVec3::ZERO);
        self.each(|noise, shift, scale, share| {
            let (own, way) = noise.at(position * scale + shift);
            let turn = 2.0 * own - 1.0;
            let sign = if turn < 0.0 { -2.0 } else { 2.0 };
            let (own, factor) = match self.fold {
                Fold::Plain => (own, 1.0),
                Fold::Ridged => (1.0 - turn.abs(), -sign),
                Fold::Turbulence => (turn.abs(), sign),
            };
            value += share * own;
            slope += way * (share * scale * factor);
        });
        (if value.is_nan() { value } else { value.clamp(0.0, 1.0) }, slope)
    }

    fn steepest(&self) -> f64 {
        let mut sum = 0.0;
        self.each(|noise, _, scale, share| sum += share * scale * noise.steepest());
        if self.fold == Fold::Plain { sum } else { 2.0 * sum }
    }

    /// Octave by octave: the coarse ones hardly change over a box in which the fine ones go through all values.
    fn bounds(&self, region: &Aabb) -> Interval {
        let (mut lo, mut hi) = (0.0, 0.0);
        self.each(|noise, shift, scale, share| {
            let own = noise.bounds(&Aabb::new(region.min * scale + shift, region.max * scale + shift));
            let turn = Interval::new(2.0 * own.lo - 1.0, 2.0 * own.hi - 1.0);
            let far = turn.lo.abs().max(turn.hi.abs());
            let near = if turn.contains(0.0) { 0.0 } else { turn.lo.abs().min(turn.hi.abs()) };
            let own = match self.fold {
                Fold::Plain => own,
                Fold::Ridged => Interval::new(1.0 - far, 1.0 - near),
                Fold::Turbulence => Interval::new(near, far),
            };
            lo += share * own.lo;
            hi += share * own.hi;
        });
        if lo.is_nan() || hi.is_nan() {
            return Interval::ALL;
        }
        Interval::new((lo - 1e-12).max(0.0).next_down(), (hi + 1e-12).min(1.0).next_up())
    }
}
