//! The bonds of fluorite.

use crate::node::lattice::{fluorite_bonds, graded, lattice, radius};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// The bonds of fluorite.
pub const NODE: Spec = Spec {
    key: Key::length(
        "fluorite",
        Required,
        "Lattice of round struts, along the bonds of fluorite, from the corners and face centres of cubes to the centres of their eighths: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: &[radius("fluorite")],
    formula: "the greatest over the struts of r − |p − q|, q the nearest of the strut",
    example: "fluorite = 1\nbounds = { box = 2.2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| graded(build, grading, "fluorite", &fluorite_bonds())),
    build: |build| lattice(build, "fluorite", &fluorite_bonds()),
    ..Spec::PLAIN
};
