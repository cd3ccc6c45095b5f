//! A shape turned about an axis of any direction.

use std::sync::Arc;

use glam::DAffine3;

use crate::field::rotation_about;
use crate::node::bend::Straight;
use crate::node::spec::{Spec, flat};
use crate::text::key::Absent::{Nothing, Number, Vector};
use crate::text::key::{Key, Kind};

/// Turned about an axis.
pub const NODE: Spec = Spec {
    key: Key::new("rotate_about", Kind::Direction, Nothing, "Turned about an axis of this direction."),
    parameters: &[
        Key::new("angle", Kind::Number, Number(0.0), "How far, counterclockwise where the axis points to the viewer.")
            .unit("degrees"),
        Key::new("pivot", Kind::Vector, Vector([0.0; 3]), "A point on the axis.").unit("units"),
    ],
    formula: "f(R⁻¹·(p − c) + c)",
    example: "box = [0.6, 0.9, 1.2]\nrotate_about = [1, 1, 1]\nangle = 40",
    bend: Some(|build| {
        let (axis, angle) = (build.direction("rotate_about")?.normalize(), build.number("angle")?);
        let pivot = build.vector("pivot")?;
        let turn = rotation_about(axis, angle.to_radians());
        let map = DAffine3::from_mat3_translation(turn, pivot - turn * pivot);
        Ok(Arc::new(Straight::new(map).ok_or_else(|| flat(build, "rotate_about"))?))
    }),
    ..Spec::PLAIN
};

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::field::rotation;

    #[test]
    fn about_the_axes_it_is_the_usual_rotation() {
        let about = |axis: DVec3, degrees: f64| rotation_about(axis, degrees.to_radians());
        for (axis, degrees) in [(DVec3::X, 30.0), (DVec3::Y, -70.0), (DVec3::Z, 200.0)] {
            assert!(about(axis, degrees).abs_diff_eq(rotation(axis * degrees), 1e-12), "{axis}");
        }
        assert!((about(DVec3::ONE.normalize(), 120.0) * DVec3::X - DVec3::Y).length() < 1e-12);
    }
}
