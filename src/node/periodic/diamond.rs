//! The bonds of diamond.

use crate::node::lattice::{diamond_bonds, graded, lattice, radius};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// The bonds of diamond.
pub const NODE: Spec = Spec {
    key: Key::length(
        "diamond",
        Required,
        "Lattice of round struts, along the bonds of diamond: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: &[radius("diamond")],
    formula: "the greatest over the struts of r − |p − q|, q the nearest of the strut",
    example: "diamond = 1\nbounds = { box = 2.2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| graded(build, grading, "diamond", &diamond_bonds())),
    build: |build| lattice(build, "diamond", &diamond_bonds()),
    ..Spec::PLAIN
};
