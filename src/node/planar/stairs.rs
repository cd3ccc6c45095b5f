//! A flight of stairs from the side.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::flat;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A flight of stairs from the side.
pub const NODE: Spec = Spec {
    key: Key::new(
        "stairs",
        Kind::Pair,
        Required,
        "Flight of stairs from the side, rising towards +x, around the origin: depth and height of a step.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    parameters: &[Key::new("steps", Kind::Whole, Number(5.0), "How many steps.").limit(Limit::Within(1.0, 1000.0))],
    formula: "the signed distance to it",
    example: "stairs = [0.35, 0.25]",
    plane: Plane::Flat,
    build: |build| {
        let (step, count) = (build.pair("stairs")?, build.whole("steps"));
        let whole = step * count as f64;
        let at = |x: i64, y: i64| DVec2::new(x as f64, y as f64) * step - whole / 2.0;
        let flight = (0..count).rev().flat_map(|i| [at(i + 1, i + 1), at(i, i + 1)]);
        let corners: Vec<DVec2> = [at(0, 0), at(count, 0)].into_iter().chain(flight).collect();
        Ok(flat(build, Outline::polygon(&corners)))
    },
    ..Spec::PLAIN
};
