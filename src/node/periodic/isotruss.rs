//! A lattice stiff in all directions.

use crate::node::lattice::{edges, face_diagonals, lattice, space_diagonals};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// A lattice stiff in all directions.
pub const NODE: Spec = Spec {
    key: Key::length(
        "isotruss",
        Required,
        "Lattice of round struts, along the edges, face diagonals and space diagonals of cubes: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: &[Key::length("radius", Of("isotruss", 0.08), "The radius of its struts.")],
    formula: "the greatest over the struts of r − |p − q|, q the nearest of the strut",
    example: "isotruss = 1\nbounds = { box = 2.2, cut = true }",
    is_endless: true,
    build: |build| lattice(build, "isotruss", &[edges(), face_diagonals(), space_diagonals()].concat()),
    ..Spec::PLAIN
};
