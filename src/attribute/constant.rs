//! One value everywhere.

use super::{Attribute, Sampler};
use crate::field::{Aabb, BATCH, Interval, Points};

/// One value everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constant<const N: usize>([f32; N]);

impl<const N: usize> Constant<N> {
    /// This value.
    pub const fn new(value: [f32; N]) -> Self {
        Self(value)
    }
}

impl<const N: usize> Attribute<N> for Constant<N> {
    fn sampler(&self) -> Box<dyn Sampler<N> + '_> {
        Box::new(*self)
    }
}

impl<const N: usize> Sampler<N> for Constant<N> {
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [[f32; N]; BATCH]) {
        out[..points.len].fill(self.0);
    }

    fn bounds(&mut self, _region: &Aabb) -> [Interval; N] {
        self.0.map(|value| Interval::new(value.into(), value.into()))
    }
}
