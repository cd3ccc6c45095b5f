//! A regular icosahedron of twenty triangles.

use crate::node::corners::icosahedron;
use crate::node::profile::convex;
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// A regular icosahedron of twenty triangles.
pub const NODE: Spec = Spec {
    key: Key::length(
        "icosahedron",
        Required,
        "Regular icosahedron of twenty triangles around the origin: the distance from its centre to its corners.",
    ),
    formula: "the signed distance to it",
    example: "icosahedron = 1",
    build: |build| {
        let radius = build.number("icosahedron")?;
        convex(build, "icosahedron", &icosahedron(radius))
    },
    ..Spec::PLAIN
};
