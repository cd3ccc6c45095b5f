//! Rhombic dodecahedron of twelve rhombs, which fills space.

use crate::node::corners::rhombic_dodecahedron;
use crate::node::profile::convex;
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// Rhombic dodecahedron of twelve rhombs, which fills space.
pub const NODE: Spec = Spec {
    key: Key::length(
        "rhombic_dodecahedron",
        Required,
        "Rhombic dodecahedron of twelve rhombs, which fills space around the origin: the distance from its centre to its corners.",
    ),
    formula: "the signed distance to it",
    example: "rhombic_dodecahedron = 1",
    build: |build| {
        let radius = build.number("rhombic_dodecahedron")?;
        convex(build, "rhombic_dodecahedron", &rhombic_dodecahedron(radius))
    },
    ..Spec::PLAIN
};
