//! A cubic lattice.

use crate::node::lattice::{edges, graded, lattice, radius};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// A cubic lattice.
pub const NODE: Spec = Spec {
    key: Key::length(
        "cubic",
        Required,
        "Lattice of round struts, along the edges of cubes: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: &[radius("cubic")],
    formula: "the greatest over the struts of r − |p − q|, q the nearest of the strut",
    example: "cubic = 1\nbounds = { box = 2.2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| graded(build, grading, "cubic", &edges())),
    build: |build| lattice(build, "cubic", &edges()),
    ..Spec::PLAIN
};
