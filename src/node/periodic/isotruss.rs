//! A lattice stiff in all directions.

use crate::node::lattice::{edges, face_diagonals, graded, lattice, radius, space_diagonals};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// A lattice stiff in all directions.
pub const NODE: Spec = Spec {
    key: Key::length(
        "isotruss",
        Required,
        "Lattice of round struts, along the edges, face diagonals and space diagonals of cubes: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: &[radius("isotruss")],
    formula: "the greatest over the struts of r − |p − q|, q the nearest of the strut",
    example: "isotruss = 1\nbounds = { box = 2.2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| {
        graded(build, grading, "isotruss", &[edges(), face_diagonals(), space_diagonals()].concat())
    }),
    build: |build| lattice(build, "isotruss", &[edges(), face_diagonals(), space_diagonals()].concat()),
    ..Spec::PLAIN
};
