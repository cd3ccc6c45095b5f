//! A ball.

use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// A ball.
pub const NODE: Spec = Spec {
    key: Key::length("sphere", Required, "A ball around the origin: its radius."),
    formula: "r − |p|",
    example: "sphere = 1",
    build: |build| {
        let radius = build.number("sphere")?;
        Ok(build.graph().sphere(radius))
    },
    ..Spec::PLAIN
};
