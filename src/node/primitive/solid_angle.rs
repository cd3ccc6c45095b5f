//! A ball as far as a cone around its centre reaches.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::{polar, revolved};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A ball as far as a cone around its centre reaches.
pub const NODE: Spec = Spec {
    key: Key::length(
        "solid_angle",
        Required,
        "What a ball and a cone with its tip in the ball's centre share: the radius.",
    ),
    parameters: &[Key::new("angle", Kind::Number, Number(40.0), "Between the z axis and the cone's side.")
        .limit(Limit::Within(0.1, 179.9))
        .unit("degrees")],
    formula: "the signed distance to it",
    example: "solid_angle = 1\nangle = 40",
    build: |build| {
        let (radius, angle) = (build.number("solid_angle")?, build.number("angle")?);
        let rim = polar(radius, 90.0 - angle);
        let mut outline = Outline::new();
        outline.line(DVec2::ZERO).line(rim).arc(DVec2::Y * radius, DVec2::ZERO, true).close();
        Ok(revolved(build, outline))
    },
    ..Spec::PLAIN
};
