//! Truncated octahedron of eight hexagons and six squares, which fills space.

use crate::node::corners::truncated_octahedron;
use crate::node::profile::convex;
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// Truncated octahedron of eight hexagons and six squares, which fills space.
pub const NODE: Spec = Spec {
    key: Key::length(
        "truncated_octahedron",
        Required,
        "Truncated octahedron of eight hexagons and six squares, which fills space around the origin: the distance from its centre to its corners.",
    ),
    formula: "the signed distance to it",
    example: "truncated_octahedron = 1",
    build: |build| {
        let radius = build.number("truncated_octahedron")?;
        convex(build, "truncated_octahedron", &truncated_octahedron(radius))
    },
    ..Spec::PLAIN
};
