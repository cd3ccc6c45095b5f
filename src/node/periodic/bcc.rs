//! A body-centred lattice.

use crate::node::lattice::{graded, lattice, radius, space_diagonals};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// A body-centred lattice.
pub const NODE: Spec = Spec {
    key: Key::length(
        "bcc",
        Required,
        "Lattice of round struts, from the corners of cubes to their centres: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: &[radius("bcc")],
    formula: "the greatest over the struts of r − |p − q|, q the nearest of the strut",
    example: "bcc = 1\nbounds = { box = 2.2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| graded(build, grading, "bcc", &space_diagonals())),
    build: |build| lattice(build, "bcc", &space_diagonals()),
    ..Spec::PLAIN
};
