//! A face-centred lattice.

use crate::node::lattice::{face_diagonals, graded, lattice, radius};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// A face-centred lattice.
pub const NODE: Spec = Spec {
    key: Key::length(
        "fcc",
        Required,
        "Lattice of round struts, along the diagonals of the faces of cubes: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: &[radius("fcc")],
    formula: "the greatest over the struts of r − |p − q|, q the nearest of the strut",
    example: "fcc = 1\nbounds = { box = 2.2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| graded(build, grading, "fcc", &face_diagonals())),
    build: |build| lattice(build, "fcc", &face_diagonals()),
    ..Spec::PLAIN
};
