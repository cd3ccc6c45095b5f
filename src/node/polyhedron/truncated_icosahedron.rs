//! Truncated icosahedron, the football of twenty hexagons and twelve pentagons.

use crate::node::corners::truncated_icosahedron;
use crate::node::profile::convex;
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// Truncated icosahedron, the football of twenty hexagons and twelve pentagons.
pub const NODE: Spec = Spec {
    key: Key::length(
        "truncated_icosahedron",
        Required,
        "Truncated icosahedron, the football of twenty hexagons and twelve pentagons around the origin: the distance from its centre to its corners.",
    ),
    formula: "the signed distance to it",
    example: "truncated_icosahedron = 1",
    build: |build| {
        let radius = build.number("truncated_icosahedron")?;
        convex(build, "truncated_icosahedron", &truncated_icosahedron(radius))
    },
    ..Spec::PLAIN
};
