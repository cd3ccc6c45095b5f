//! A ring.

use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// A ring.
pub const NODE: Spec = Spec {
    key: Key::length("torus", Required, "A ring around the z axis: the radius of its middle line."),
    parameters: &[Key::length("tube", Of("torus", 0.25), "The radius of its tube.")],
    formula: "s − |(|(x, y)| − r, z)|",
    example: "torus = 0.8",
    build: |build| {
        let (radius, tube) = (build.number("torus")?, build.number("tube")?);
        Ok(build.graph().torus(radius, tube))
    },
    ..Spec::PLAIN
};
