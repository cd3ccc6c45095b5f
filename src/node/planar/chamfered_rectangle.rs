//! A rectangle with its corners cut off.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::flat;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A rectangle with its corners cut off.
pub const NODE: Spec = Spec {
    key: Key::new(
        "chamfered_rectangle",
        Kind::Pair,
        Required,
        "Rectangle around the origin with its corners cut off at 45 degrees: its edge lengths; one number is a square.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    parameters: &[Key::length("chamfer", Number(0.2), "How much of each edge is cut off at a corner.")],
    formula: "the signed distance to it",
    example: "chamfered_rectangle = [1.6, 1]",
    plane: Plane::Flat,
    build: |build| {
        let (half, cut) = (build.pair("chamfered_rectangle")? / 2.0, build.number("chamfer")?);
        if cut >= half.min_element() {
            let problem = format!("`chamfer` must be less than half of the shorter edge, {}", half.min_element());
            return Err(build.wrong("chamfer", problem).help("a smaller chamfer, or longer edges"));
        }
        let (x, y) = (half.x, half.y);
        let corners = [
            [x - cut, y],
            [cut - x, y],
            [-x, y - cut],
            [-x, cut - y],
            [cut - x, -y],
            [x - cut, -y],
            [x, cut - y],
            [x, y - cut],
        ];
        Ok(flat(build, Outline::polygon(&corners.map(DVec2::from))))
    },
    ..Spec::PLAIN
};
