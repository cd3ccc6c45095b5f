//! The plane of a morph whose objects are shapes of one: they are blended in it, as the papers' are, and extruded for what is
//! baked.

use glam::DVec3;

use super::motion::Similarity;
use crate::field::Aabb;

/// The plane of two shapes, and how far their morph is extruded from it. The objects' motions keep them in it.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// From the bottom to the top, half of it to either side, world units.
    pub height: f64,
    /// Where z = 0 stands as the span starts.
    pub(super) placement: Similarity,
}

impl Plane {
    /// The plane z = 0 where a morph is placed as its span starts; `height` in the morph's own units.
    pub fn new(height: f64, placement: &Similarity) -> Self {
        Self { height: height * placement.scale(), placement: placement.rigid() }
    }

    /// The box around all that is extruded from a box of the plane, which stands in the world.
    pub(super) fn extruded(&self, aabb: Aabb, normal: DVec3) -> Aabb {
        let half = normal.abs() * (self.height * 0.5);
        Aabb::new(aabb.min - half, aabb.max + half)
    }
}
