//! A regular dodecahedron of twelve pentagons.

use crate::node::corners::dodecahedron;
use crate::node::profile::convex;
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// A regular dodecahedron of twelve pentagons.
pub const NODE: Spec = Spec {
    key: Key::length(
        "dodecahedron",
        Required,
        "Regular dodecahedron of twelve pentagons around the origin: the distance from its centre to its corners.",
    ),
    formula: "the signed distance to it",
    example: "dodecahedron = 1",
    build: |build| {
        let radius = build.number("dodecahedron")?;
        convex(build, "dodecahedron", &dodecahedron(radius))
    },
    ..Spec::PLAIN
};
