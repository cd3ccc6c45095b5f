//! A body-centred lattice.

use crate::node::lattice::{lattice, space_diagonals};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// A body-centred lattice.
pub const NODE: Spec = Spec {
    key: Key::length(
        "bcc",
        Required,
        "Lattice of round struts, from the corners of cubes to their centres: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: &[Key::length("radius", Of("bcc", 0.08), "The radius of its struts.")],
    formula: "the greatest over the struts of r − |p − q|, q the nearest of the strut",
    example: "bcc = 1\nbounds = { box = 2.2, cut = true }",
    is_endless: true,
    build: |build| lattice(build, "bcc", &space_diagonals()),
    ..Spec::PLAIN
};
