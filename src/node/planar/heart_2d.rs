//! A heart of the plane.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::flat;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// A heart of the plane.
pub const NODE: Spec = Spec {
    key: Key::length("heart_2d", Required, "Heart of the plane, its tip down, around the origin: its width."),
    formula: "the signed distance to a square on its corner with half a disc on each of its upper sides",
    example: "heart_2d = 1.8",
    plane: Plane::Flat,
    build: |build| {
        let width = build.number("heart_2d")?;
        // Of a square of diagonal 2, its lower corner at the origin, with discs of radius 1/√2 around (±½, 1½).
        let round = 0.5_f64.sqrt();
        let scale = width / (1.0 + 2.0 * round);
        let middle = (1.5 + round) / 2.0;
        let at = |x: f64, y: f64| DVec2::new(x, y - middle) * scale;
        let mut outline = Outline::new();
        outline
            .line(at(0.0, 0.0))
            .line(at(1.0, 1.0))
            .arc(at(0.0, 2.0), at(0.5, 1.5), true)
            .arc(at(-1.0, 1.0), at(-0.5, 1.5), true)
            .close();
        Ok(flat(build, outline))
    },
    ..Spec::PLAIN
};
