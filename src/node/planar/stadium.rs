//! All near a line of the plane.

use glam::DVec3;

use crate::field::{Joined, Strut, Struts};
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// All near a line of the plane.
pub const NODE: Spec = Spec {
    key: Key::length("stadium", Required, "All that is near a level line around the origin: the radius.")
        .also(&["slot"]),
    parameters: &[Key::length("length", Of("stadium", 2.0), "The length of the line.")],
    formula: "r − |p − q|, q the nearest of the line",
    example: "stadium = 0.4",
    plane: Plane::Flat,
    build: |build| {
        let (radius, half) = (build.number("stadium")?, build.number("length")? / 2.0);
        let strut = Strut::new(DVec3::NEG_X * half, DVec3::X * half, [radius; 2]);
        Ok(build.graph().field(Joined::shared(Struts::new(vec![strut]).flattened())))
    },
    ..Spec::PLAIN
};
