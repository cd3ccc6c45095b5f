//! An attribute seen from another space: positions are carried into its own before they are sampled.

use glam::DVec3;

use super::Sampler;
use crate::field::{Aabb, BATCH, Gradients, Interval, Points};

/// How positions of one space become positions of another.
pub trait SpaceMap: Send {
    /// A batch there.
    fn points(&self, points: &Points, out: &mut Points);

    /// Gradients there, as they are here; false where the map does not say.
    fn gradients(&self, _len: usize, _out: &mut Gradients) -> bool {
        false
    }

    /// A box there that holds all of a box here.
    fn region(&self, region: &Aabb) -> Aabb;
}

/// Samples an attribute of the other space at positions of this one.
pub struct MappedSampler<'a, M, const N: usize> {
    inner: Box<dyn Sampler<N> + 'a>,
    map: M,
    there: Box<Points>,
}

impl<'a, M: SpaceMap, const N: usize> MappedSampler<'a, M, N> {
    /// The sampler of the other space's attribute, and the map to there.
    // Within whoever makes it, the batch would take its place on the stack once for each of many maps in one another.
    #[inline(never)]
    pub fn new(inner: Box<dyn Sampler<N> + 'a>, map: M) -> Self {
        Self { inner, map, there: Box::new(Points::new(DVec3::ZERO)) }
    }
}

impl<M: SpaceMap, const N: usize> Sampler<N> for MappedSampler<'_, M, N> {
    fn enter(&mut self, region: &Aabb) {
        self.inner.enter(&self.map.region(region));
    }

    fn leave(&mut self) {
        self.inner.leave();
    }

    fn sample(&mut self, points: &Points, out: &mut [[f32; N]; BATCH]) {
        self.map.points(points, &mut self.there);
        self.inner.sample(&self.there, out);
    }

    fn gradients(&mut self, points: &Points, out: &mut [Gradients; N]) -> bool {
        self.map.points(points, &mut self.there);
        self.inner.gradients(&self.there, out) && out.iter_mut().all(|out| self.map.gradients(points.len, out))
    }

    fn bounds(&mut self, region: &Aabb) -> [Interval; N] {
        self.inner.bounds(&self.map.region(region))
    }
}
