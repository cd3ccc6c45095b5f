//! A piece of a disc.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::{flat, polar};
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A piece of a disc.
pub const NODE: Spec = Spec {
    key: Key::length("pie", Required, "Piece of a disc around the origin: its radius."),
    parameters: &[Key::new("angle", Kind::Number, Number(90.0), "How far it goes round, its middle on the y axis.")
        .limit(Limit::Within(0.1, 359.9))
        .unit("degrees")],
    formula: "the signed distance to it",
    example: "pie = 1\nangle = 250",
    plane: Plane::Flat,
    build: |build| {
        let (radius, half) = (build.number("pie")?, build.number("angle")? / 2.0);
        let mut outline = Outline::new();
        let (from, to) = (polar(radius, 90.0 - half), polar(radius, 90.0 + half));
        outline.line(DVec2::ZERO).line(from).arc(to, DVec2::ZERO, true).close();
        Ok(flat(build, outline))
    },
    ..Spec::PLAIN
};
