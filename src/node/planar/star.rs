//! A star.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::{flat, polar};
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Number, Of, Required};
use crate::text::key::{Key, Kind, Limit};

/// A star.
pub const NODE: Spec = Spec {
    key: Key::length("star", Required, "Star around the origin, a tip up: the distance from its middle to its tips."),
    parameters: &[
        Key::new("tips", Kind::Whole, Number(5.0), "How many tips it has.").limit(Limit::Within(2.0, 500.0)),
        Key::length("inner", Of("star", 0.45), "The distance from its middle to the corners between its tips."),
    ],
    formula: "the signed distance to it",
    example: "star = 1",
    plane: Plane::Flat,
    build: |build| {
        let (outer, inner, tips) = (build.number("star")?, build.number("inner")?, build.whole("tips"));
        let corner = |i: i64| polar(if i % 2 == 0 { outer } else { inner }, 90.0 + 180.0 * i as f64 / tips as f64);
        let corners: Vec<DVec2> = (0..2 * tips).map(corner).collect();
        Ok(flat(build, Outline::polygon(&corners)))
    },
    ..Spec::PLAIN
};
