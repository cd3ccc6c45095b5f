//! Attributes seen through affine maps and mirrors.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use crate::attribute::{Attribute, MappedSampler, Sampler, SpaceMap};
use crate::field::{Aabb, Points};
use crate::node::bend::Bend;

/// How positions of the world become positions of the attribute's own space.
#[derive(Clone)]
pub(crate) enum Way {
    /// Back through where the shape was placed: the map from the world to its own space.
    Back(DAffine3),
    /// Back through what bends its space.
    Bent(Arc<dyn Bend>),
}

/// An attribute that stands elsewhere.
pub(crate) struct Placed<const N: usize> {
    /// The attribute in its own space.
    pub inner: Arc<dyn Attribute<N>>,
    /// The way there.
    pub way: Way,
}

impl SpaceMap for Way {
    fn region(&self, region: &Aabb) -> Aabb {
        let moved = match self {
            Self::Back(map) => {
                let corners = region.corners().map(|corner| map.transform_point3(corner));
                let around = |grown: Aabb, corner: &DVec3| grown.union(Aabb::new(*corner, *corner));
                corners.iter().fold(Aabb::new(corners[0], corners[0]), around)
            }
            Self::Bent(bend) => bend.region(region),
        };
        // Corners are rounded each on their own.
        let slack = 1e-12 * (moved.min.abs().max(moved.max.abs()).max_element() + moved.size().max_element());
        moved.grown(slack)
    }

    /// A batch there: the origin in `f64`, the offsets in `f32`.
    fn points(&self, points: &Points, out: &mut Points) {
        match self {
            Self::Back(map) => {
                (out.origin, out.len) = (map.transform_point3(points.origin), points.len);
                turned(&map.matrix3, points, out);
            }
            Self::Bent(bend) => bend.points_back(points, out),
        }
    }
}

/// The offsets turned and stretched, in `f64`.
#[multiversion::multiversion(targets = "simd")]
fn turned(matrix: &DMat3, points: &Points, out: &mut Points) {
    let [a, b, c] = matrix.to_cols_array_2d();
    for i in 0..points.len {
        let (x, y, z) = (f64::from(points.x[i]), f64::from(points.y[i]), f64::from(points.z[i]));
        out.x[i] = (a[0] * x + b[0] * y + c[0] * z) as f32;
        out.y[i] = (a[1] * x + b[1] * y + c[1] * z) as f32;
        out.z[i] = (a[2] * x + b[2] * y + c[2] * z) as f32;
    }
}

impl<const N: usize> Attribute<N> for Placed<N> {
    fn sampler(&self) -> Box<dyn Sampler<N> + '_> {
        Box::new(MappedSampler::new(self.inner.sampler(), self.way.clone()))
    }
}

#[cfg(test)]
mod tests {
    use crate::attribute::LinearRgb;
    use crate::field::BATCH;
    use glam::Vec3;

    use super::*;
    use crate::node::space::mirror::Fold;

    /// The position itself as a colour.
    struct Position;

    impl Attribute<3> for Position {
        fn sampler(&self) -> Box<dyn Sampler<3> + '_> {
            Box::new(Self)
        }
    }

    impl Sampler<3> for Position {
        fn enter(&mut self, _region: &Aabb) {}
        fn leave(&mut self) {}
        fn sample(&mut self, points: &Points, out: &mut [LinearRgb; BATCH]) {
            for (i, out) in out.iter_mut().enumerate().take(points.len) {
                *out = points.position(i).as_vec3().to_array();
            }
        }
    }

    fn sampled(way: Way, at: DVec3) -> LinearRgb {
        let colour = Placed { inner: Arc::new(Position), way };
        let mut points = Points::new(DVec3::new(-1.0, 0.5, 2.0));
        points.push((at - points.origin).as_vec3());
        let mut out = [[0.0; 3]; BATCH];
        let mut sampler = colour.sampler();
        sampler.enter(&Aabb::new(at, at));
        sampler.sample(&points, &mut out);
        sampler.leave();
        out[0]
    }

    #[test]
    fn positions_go_back_to_their_own_space() {
        let map = DAffine3::from_scale_rotation_translation(
            DVec3::new(2.0, 1.0, 4.0),
            glam::DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2),
            DVec3::new(10.0, 0.0, 0.0),
        );
        // Own (1, 0, 1) is scaled to (2, 0, 4), turned to (0, 2, 4), moved to (10, 2, 4).
        let [x, y, z] = sampled(Way::Back(map.inverse()), DVec3::new(10.0, 2.0, 4.0));
        assert!((Vec3::new(x, y, z) - Vec3::new(1.0, 0.0, 1.0)).length() < 1e-6);
        assert_eq!(sampled(Way::Bent(Arc::new(Fold(0))), DVec3::new(-3.0, 1.0, 0.0)), [3.0, 1.0, 0.0]);
        assert_eq!(sampled(Way::Bent(Arc::new(Fold(0))), DVec3::new(3.0, 1.0, 0.0)), [3.0, 1.0, 0.0]);
    }
}
