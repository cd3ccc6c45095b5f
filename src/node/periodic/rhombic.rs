//! Rhombic dodecahedra.

use crate::node::lattice::{graded, lattice, radius, rhombic_dodecahedra};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// Rhombic dodecahedra.
pub const NODE: Spec = Spec {
    key: Key::length(
        "rhombic",
        Required,
        "Lattice of round struts, along the edges of rhombic dodecahedra that fill space: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: &[radius("rhombic")],
    formula: "the greatest over the struts of r − |p − q|, q the nearest of the strut",
    example: "rhombic = 1\nbounds = { box = 2.2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| graded(build, grading, "rhombic", &rhombic_dodecahedra())),
    build: |build| lattice(build, "rhombic", &rhombic_dodecahedra()),
    ..Spec::PLAIN
};
