//! A regular polygon.

use crate::field::Outline;
use crate::node::profile::{flat, regular};
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A regular polygon.
pub const NODE: Spec = Spec {
    key: Key::length(
        "regular_polygon",
        Required,
        "Regular polygon around the origin, a corner up: the distance from its middle to its corners.",
    ),
    parameters: &[
        Key::new("sides", Kind::Whole, Number(6.0), "How many corners it has.").limit(Limit::Within(3.0, 1000.0))
    ],
    formula: "the signed distance to it",
    example: "regular_polygon = 1",
    plane: Plane::Flat,
    build: |build| {
        let (radius, sides) = (build.number("regular_polygon")?, build.whole("sides"));
        Ok(flat(build, Outline::polygon(&regular(sides, radius))))
    },
    ..Spec::PLAIN
};
