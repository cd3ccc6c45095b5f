//! A bowl.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::revolved;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::{Key, Kind};

/// A bowl.
pub const NODE: Spec = Spec {
    key: Key::length(
        "cut_hollow_sphere",
        Required,
        "Bowl around the origin, the wall of a ball below a plane, with a round rim: its outer radius.",
    )
    .also(&["bowl"]),
    parameters: &[
        Key::length("wall", Of("cut_hollow_sphere", 0.1), "The thickness of its wall."),
        Key::new("cut", Kind::Number, Of("cut_hollow_sphere", 0.25), "The z of the middle of its rim.").unit("units"),
    ],
    formula: "the signed distance to it",
    example: "cut_hollow_sphere = 1\nwall = 0.15\ncut = 0.2",
    build: |build| {
        let (outer, wall, cut) = (build.number("cut_hollow_sphere")?, build.number("wall")?, build.number("cut")?);
        let (inner, middle) = (outer - wall, outer - wall / 2.0);
        if inner <= 0.0 {
            let problem = format!("`wall` must be less than the radius, {outer}");
            return Err(build.wrong("wall", problem).help("a thinner wall, or `cut_sphere`"));
        }
        // Nearer to the poles the round rim would reach over the axis.
        let most = (middle * middle - wall * wall / 4.0).max(0.0).sqrt();
        if cut.abs() >= most {
            let problem = format!("`cut` must lie between {} and {most}", -most);
            return Err(build.wrong("cut", problem).help("`hollow_sphere` is the whole wall"));
        }
        let rim = DVec2::new((middle * middle - cut * cut).sqrt(), cut) / middle;
        let mut outline = Outline::new();
        outline
            .line(DVec2::NEG_Y * outer)
            .arc(rim * outer, DVec2::ZERO, true)
            .arc(rim * inner, rim * middle, true)
            .arc(DVec2::NEG_Y * inner, DVec2::ZERO, false)
            .close();
        Ok(revolved(build, outline))
    },
    ..Spec::PLAIN
};
