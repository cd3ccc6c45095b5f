//! All between two planes.

use crate::node::spec::Spec;
use crate::text::key::Absent::{Required, Vector};
use crate::text::key::{Key, Kind};

/// All between two planes.
pub const NODE: Spec = Spec {
    key: Key::length(
        "slab",
        Required,
        "All between two planes around the origin: the thickness. Without end: for cutting.",
    ),
    parameters: &[Key::new("normal", Kind::Vector, Vector([0.0, 0.0, 1.0]), "The direction across it.")],
    formula: "w/2 − |n·p|",
    example: "slab = 0.4\nbounds = 2",
    is_endless: true,
    build: |build| {
        let (normal, thickness) = (build.direction("normal")?, build.number("slab")?);
        Ok(build.graph().slab(normal, thickness))
    },
    ..Spec::PLAIN
};
