//! All near a straight line.

use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// All near a straight line.
pub const NODE: Spec = Spec {
    key: Key::length("capsule", Required, "All that is near a straight line: the radius."),
    parameters: &[Key::length("length", Of("capsule", 2.0), "The length of the line, along z around the origin.")],
    formula: "r − |p − q|, q the nearest of the line",
    example: "capsule = 0.5",
    build: |build| {
        let (radius, length) = (build.number("capsule")?, build.number("length")?);
        Ok(build.graph().capsule(radius, length))
    },
    ..Spec::PLAIN
};
