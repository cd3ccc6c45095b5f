//! A ball with its top cut off.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::revolved;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::{Key, Kind};

/// A ball with its top cut off.
pub const NODE: Spec = Spec {
    key: Key::length("cut_sphere", Required, "Ball around the origin without what lies above a plane: its radius."),
    parameters: &[
        Key::new("cut", Kind::Number, Of("cut_sphere", 0.5), "The z of the plane that cuts it.").unit("units")
    ],
    formula: "the signed distance to it",
    example: "cut_sphere = 1\ncut = 0.4",
    build: |build| {
        let (radius, cut) = (build.number("cut_sphere")?, build.number("cut")?);
        if cut.abs() >= radius {
            let problem = format!("`cut` must lie within the ball: between {} and {radius}", -radius);
            return Err(build.wrong("cut", problem).help("`sphere` is the whole ball"));
        }
        let rim = DVec2::new((radius * radius - cut * cut).sqrt(), cut);
        let mut outline = Outline::new();
        outline.line(DVec2::NEG_Y * radius).arc(rim, DVec2::ZERO, true).line(DVec2::Y * cut).close();
        Ok(revolved(build, outline))
    },
    ..Spec::PLAIN
};
