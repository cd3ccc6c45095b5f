//! A regular octahedron, its corners on the axes.

use crate::node::corners::octahedron;
use crate::node::profile::convex;
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// A regular octahedron, its corners on the axes.
pub const NODE: Spec = Spec {
    key: Key::length(
        "octahedron",
        Required,
        "Regular octahedron, its corners on the axes around the origin: the distance from its centre to its corners.",
    ),
    formula: "the signed distance to it",
    example: "octahedron = 1",
    build: |build| {
        let radius = build.number("octahedron")?;
        convex(build, "octahedron", &octahedron(radius))
    },
    ..Spec::PLAIN
};
