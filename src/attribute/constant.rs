//! One colour everywhere.

use super::{Colour, ColourSampler, LinearRgb};
use crate::field::{Aabb, BATCH, Points};

/// One colour everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constant(LinearRgb);

impl Constant {
    /// This colour.
    pub const fn new(colour: LinearRgb) -> Self {
        Self(colour)
    }
}

impl Colour for Constant {
    fn sampler(&self) -> Box<dyn ColourSampler + '_> {
        Box::new(*self)
    }
}

impl ColourSampler for Constant {
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [LinearRgb; BATCH]) {
        out[..points.len].fill(self.0);
    }
}
