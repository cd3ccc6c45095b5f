//! A parallelogram.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::flat;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A parallelogram.
pub const NODE: Spec = Spec {
    key: Key::new(
        "parallelogram",
        Kind::Pair,
        Required,
        "Parallelogram around the origin: the length of its level edges and its height.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    parameters: &[Key::new(
        "lean",
        Kind::Number,
        Number(0.4),
        "How far its upper edge lies to the right of the lower one.",
    )
    .unit("units")],
    formula: "the signed distance to it",
    example: "parallelogram = [1.3, 0.9]",
    plane: Plane::Flat,
    build: |build| {
        let (half, lean) = (build.pair("parallelogram")? / 2.0, build.number("lean")? / 2.0);
        let (x, y) = (half.x, half.y);
        let corners = [[-x - lean, -y], [x - lean, -y], [x + lean, y], [lean - x, y]].map(DVec2::from);
        Ok(flat(build, Outline::polygon(&corners)))
    },
    ..Spec::PLAIN
};
