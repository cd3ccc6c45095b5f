//! Cuboctahedron of eight triangles and six squares.

use crate::node::corners::cuboctahedron;
use crate::node::profile::convex;
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// Cuboctahedron of eight triangles and six squares.
pub const NODE: Spec = Spec {
    key: Key::length(
        "cuboctahedron",
        Required,
        "Cuboctahedron of eight triangles and six squares around the origin: the distance from its centre to its corners.",
    ),
    formula: "the signed distance to it",
    example: "cuboctahedron = 1",
    build: |build| {
        let radius = build.number("cuboctahedron")?;
        convex(build, "cuboctahedron", &cuboctahedron(radius))
    },
    ..Spec::PLAIN
};
