//! Numbers that are found at one position after another, wherever that is.

use glam::DVec3;

use super::Sampler;
use crate::field::{Aabb, BATCH, Interval, Points};

/// A number at any position.
pub trait Positional: Send + Sync {
    /// The number at a position.
    fn at(&self, position: DVec3) -> f32;

    /// What it is anywhere.
    fn range(&self) -> Interval;
}

/// Asks at each position by itself, whatever region it is in.
pub struct PositionalSampler<'a, P>(pub &'a P);

impl<P: Positional> Sampler<1> for PositionalSampler<'_, P> {
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [[f32; 1]; BATCH]) {
        for (i, out) in out.iter_mut().enumerate().take(points.len) {
            *out = [self.0.at(points.position(i))];
        }
    }

    fn bounds(&mut self, _region: &Aabb) -> [Interval; 1] {
        [self.0.range()]
    }
}
