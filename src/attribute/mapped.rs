//! A colour seen from another space: positions are carried into its own before they are sampled.

use glam::DVec3;

use super::{ColourSampler, LinearRgb};
use crate::field::{Aabb, BATCH, Points};

/// How positions of one space become positions of another.
pub trait SpaceMap {
    /// A batch there.
    fn points(&self, points: &Points, out: &mut Points);

    /// A box there that holds all of a box here.
    fn region(&self, region: &Aabb) -> Aabb;
}

/// Samples a colour of the other space at positions of this one.
pub struct MappedSampler<'a, M> {
    inner: Box<dyn ColourSampler + 'a>,
    map: M,
    there: Points,
}

impl<'a, M: SpaceMap> MappedSampler<'a, M> {
    /// The sampler of the other space's colour, and the map to there.
    pub fn new(inner: Box<dyn ColourSampler + 'a>, map: M) -> Self {
        Self { inner, map, there: Points::new(DVec3::ZERO) }
    }
}

impl<M: SpaceMap> ColourSampler for MappedSampler<'_, M> {
    fn enter(&mut self, region: &Aabb) {
        self.inner.enter(&self.map.region(region));
    }

    fn leave(&mut self) {
        self.inner.leave();
    }

    fn sample(&mut self, points: &Points, out: &mut [LinearRgb; BATCH]) {
        self.map.points(points, &mut self.there);
        self.inner.sample(&self.there, out);
    }
}
