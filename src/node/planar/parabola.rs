//! What lies below a parabola.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::flat;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// What lies below a parabola.
pub const NODE: Spec = Spec {
    key: Key::length(
        "parabola",
        Required,
        "What lies between a parabola, its top up, and a level line, around the origin: the length of that line.",
    ),
    parameters: &[Key::length("height", Of("parabola", 0.8), "From the line to the top.")],
    formula: "the signed distance to it, the parabola of straight pieces",
    example: "parabola = 1.6",
    plane: Plane::Flat,
    build: |build| {
        /// Straight pieces: 1e-5 of the height off at most.
        const PIECES: i32 = 200;
        let (half, height) = (build.number("parabola")? / 2.0, build.number("height")?);
        let corner = |i: i32| {
            let share = 1.0 - 2.0 * f64::from(i) / f64::from(PIECES);
            DVec2::new(half * share, height * (0.5 - share * share))
        };
        let corners: Vec<DVec2> = (0..=PIECES).map(corner).collect();
        Ok(flat(build, Outline::polygon(&corners)))
    },
    ..Spec::PLAIN
};
