//! A cylinder.

use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// A cylinder.
pub const NODE: Spec = Spec {
    key: Key::length("cylinder", Required, "A cylinder along z around the origin: its radius."),
    parameters: &[Key::length("height", Of("cylinder", 2.0), "From its bottom to its top.")],
    formula: "the signed distance to it",
    example: "cylinder = 0.6",
    build: |build| {
        let (radius, height) = (build.number("cylinder")?, build.number("height")?);
        Ok(build.graph().cylinder(radius, height))
    },
    ..Spec::PLAIN
};
