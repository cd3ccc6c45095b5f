//! All behind a plane.

use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind};

/// All behind a plane.
pub const NODE: Spec = Spec {
    key: Key::new(
        "half_space",
        Kind::Vector,
        Required,
        "All that lies behind a plane: the direction that points out of it, of any length but 0. Without end: for cutting.",
    ),
    parameters: &[Key::new(
        "offset_along",
        Kind::Number,
        Number(0.0),
        "How far the plane lies from the origin, along that direction.",
    )
    .unit("units")],
    formula: "d − n·p",
    example: "half_space = [0, 0, 1]\nbounds = 2",
    is_endless: true,
    build: |build| {
        let (normal, offset) = (build.direction("half_space")?, build.number("offset_along")?);
        Ok(build.graph().half_space(normal, offset))
    },
    ..Spec::PLAIN
};
