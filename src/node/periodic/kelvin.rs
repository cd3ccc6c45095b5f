//! Kelvin's foam.

use crate::node::lattice::{graded, lattice, radius, truncated_octahedra};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// Kelvin's foam.
pub const NODE: Spec = Spec {
    key: Key::length(
        "kelvin",
        Required,
        "Lattice of round struts, along the edges of truncated octahedra that fill space, Kelvin's foam: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: &[radius("kelvin")],
    formula: "the greatest over the struts of r − |p − q|, q the nearest of the strut",
    example: "kelvin = 1\nbounds = { box = 2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| graded(build, grading, "kelvin", &truncated_octahedra())),
    build: |build| lattice(build, "kelvin", &truncated_octahedra()),
    ..Spec::PLAIN
};
