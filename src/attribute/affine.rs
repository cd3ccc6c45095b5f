//! A vector that changes evenly over space, such as the way that the points of a rigid body go.

use glam::{DAffine3, DMat3, DVec3};

use super::{Attribute, Sampler};
use crate::field::{Aabb, BATCH, Points};

/// M·x + o at each world position x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AffineVector {
    matrix: DMat3,
    offset: DVec3,
}

impl AffineVector {
    /// The way from where each point stands to where it stands later, of what is placed in the world by `now` and
    /// `later`.
    pub fn of_move(now: DAffine3, later: DAffine3) -> Self {
        let map = later * now.inverse();
        Self { matrix: map.matrix3 - DMat3::IDENTITY, offset: map.translation }
    }

    /// The vector at a position.
    pub fn at(&self, position: DVec3) -> DVec3 {
        self.matrix * position + self.offset
    }
}

impl Attribute<3> for AffineVector {
    fn sampler(&self) -> Box<dyn Sampler<3> + '_> {
        Box::new(*self)
    }
}

impl Sampler<3> for AffineVector {
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [[f32; 3]; BATCH]) {
        for (i, out) in out.iter_mut().enumerate().take(points.len) {
            *out = self.at(points.position(i)).as_vec3().to_array();
        }
    }
}
