//! A regular tetrahedron, upright along z.

use crate::node::corners::tetrahedron;
use crate::node::profile::convex;
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// A regular tetrahedron, upright along z.
pub const NODE: Spec = Spec {
    key: Key::length(
        "tetrahedron",
        Required,
        "Regular tetrahedron, upright along z around the origin: the distance from its centre to its corners.",
    ),
    formula: "the signed distance to it",
    example: "tetrahedron = 1",
    build: |build| {
        let radius = build.number("tetrahedron")?;
        convex(build, "tetrahedron", &tetrahedron(radius))
    },
    ..Spec::PLAIN
};
