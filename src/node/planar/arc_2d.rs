//! An arc with round ends.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::{flat, polar};
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Number, Of, Required};
use crate::text::key::{Key, Kind, Limit};

/// An arc with round ends.
pub const NODE: Spec = Spec {
    key: Key::length("arc_2d", Required, "Arc around the origin with round ends: the radius of its middle line."),
    parameters: &[
        Key::length("width", Of("arc_2d", 0.3), "Its width."),
        Key::new("angle", Kind::Number, Number(220.0), "How far its middle line goes round, its middle on the y axis.")
            .limit(Limit::Within(0.1, 359.9))
            .unit("degrees"),
    ],
    formula: "the signed distance to it",
    example: "arc_2d = 0.8",
    plane: Plane::Flat,
    build: |build| {
        let (radius, wide) = (build.number("arc_2d")?, build.number("width")? / 2.0);
        let half = build.number("angle")? / 2.0;
        if wide >= radius {
            let problem = format!("`width` must be less than twice the radius, {}", 2.0 * radius);
            return Err(build.wrong("width", problem).help("a narrower arc, or `pie`"));
        }
        let [right, left] = [90.0 - half, 90.0 + half].map(|degrees| polar(1.0, degrees));
        // The ends would cross where they are nearer to one another than the width.
        if half > 90.0 && radius * left.distance(right) < 2.0 * wide {
            return Err(build
                .wrong("angle", "the ends of the arc meet")
                .help("a smaller angle, a narrower arc, or `ring`"));
        }
        let mut outline = Outline::new();
        outline
            .line(right * (radius + wide))
            .arc(left * (radius + wide), DVec2::ZERO, true)
            .arc(left * (radius - wide), left * radius, true)
            .arc(right * (radius - wide), DVec2::ZERO, false)
            .arc(right * (radius + wide), right * radius, true)
            .close();
        Ok(flat(build, outline))
    },
    ..Spec::PLAIN
};
