//! Two balls and the cone that touches both.

use glam::DVec3;

use crate::field::{Joined, Strut, Struts};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// Two balls and the cone that touches both.
pub const NODE: Spec = Spec {
    key: Key::length(
        "round_cone",
        Required,
        "Tapered capsule along z: two balls and the cone that touches both. The radius of the lower one.",
    )
    .also(&["tapered_capsule"]),
    parameters: &[
        Key::length("top", Of("round_cone", 0.5), "The radius of the upper ball."),
        Key::length(
            "height",
            Of("round_cone", 2.0),
            "From the centre of one ball to that of the other, around the origin.",
        ),
    ],
    formula: "max over t of (1 − t)·r + t·s − |p − (1 − t)·a − t·b|",
    example: "round_cone = 0.6",
    build: |build| {
        let (bottom, top, height) = (build.number("round_cone")?, build.number("top")?, build.number("height")?);
        let half = DVec3::Z * (height / 2.0);
        let strut = Strut::new(-half, half, [bottom, top]);
        Ok(build.graph().field(Joined::shared(Struts::new(vec![strut]))))
    },
    ..Spec::PLAIN
};
