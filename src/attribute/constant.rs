//! One value everywhere.

use super::{Attribute, Sampler};
use crate::field::{Aabb, BATCH, Gradients, Interval, Points};

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

    fn gradients(&mut self, points: &Points, out: &mut [Gradients; N]) -> bool {
        for (out, value) in out.iter_mut().zip(self.0) {
            out.value[..points.len].fill(value);
            for slopes in [&mut out.dx, &mut out.dy, &mut out.dz] {
                slopes[..points.len].fill(0.0);
            }
        }
        true
    }

    fn bounds(&mut self, _region: &Aabb) -> [Interval; N] {
        self.0.map(|value| Interval::new(value.into(), value.into()))
    }
}
