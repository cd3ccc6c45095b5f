//! A shape turned towards a point.

use std::sync::Arc;

use glam::DAffine3;

use crate::node::bend::Straight;
use crate::node::copied::facing;
use crate::node::spec::{Spec, flat};
use crate::text::key::Absent::{Nothing, Vector};
use crate::text::key::{Key, Kind};

/// Turned so that its z axis points at a place.
pub const NODE: Spec = Spec {
    key: Key::new("look_at", Kind::Vector, Nothing, "Turned so that its z axis points from the origin to this place."),
    parameters: &[Key::new(
        "upward",
        Kind::Direction,
        Vector([0.0, 1.0, 0.0]),
        "Its y axis points to the side of this direction. Where both are the same, to any.",
    )],
    formula: "f(R⁻¹·p)",
    example: "cone = 0.4\nheight = 1.2\nlook_at = [1, 0.5, 1]",
    bend: Some(|build| {
        let (target, up) = (build.direction("look_at")?, build.direction("upward")?);
        let map = DAffine3::from_mat3(facing(target, up));
        Ok(Arc::new(Straight::new(map).ok_or_else(|| flat(build, "look_at"))?))
    }),
    ..Spec::PLAIN
};
