//! The octet truss.

use crate::node::lattice::{face_diagonals, graded, lattice, octahedron, radius};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// The octet truss.
pub const NODE: Spec = Spec {
    key: Key::length(
        "octet",
        Required,
        "Lattice of round struts, along the edges of octahedra and tetrahedra that fill space, the octet truss: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: &[radius("octet")],
    formula: "the greatest over the struts of r − |p − q|, q the nearest of the strut",
    example: "octet = 1\nbounds = { box = 2.2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| graded(build, grading, "octet", &[face_diagonals(), octahedron()].concat())),
    build: |build| lattice(build, "octet", &[face_diagonals(), octahedron()].concat()),
    ..Spec::PLAIN
};
