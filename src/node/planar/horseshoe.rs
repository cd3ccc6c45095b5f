//! A horseshoe.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::{flat, polar};
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Number, Of, Required};
use crate::text::key::{Key, Kind, Limit};

/// A horseshoe.
pub const NODE: Spec = Spec {
    key: Key::length(
        "horseshoe",
        Required,
        "Horseshoe, open below, around the origin: the radius of the middle line of its bend.",
    ),
    parameters: &[
        Key::length("width", Of("horseshoe", 0.35), "Its width."),
        Key::new("angle", Kind::Number, Number(240.0), "How far its bend goes round.")
            .limit(Limit::Within(10.0, 340.0))
            .unit("degrees"),
        Key::new("length", Kind::Number, Of("horseshoe", 0.4), "The length of its straight ends.")
            .limit(Limit::NotNegative)
            .unit("units"),
    ],
    formula: "the signed distance to it",
    example: "horseshoe = 0.8",
    plane: Plane::Flat,
    build: |build| {
        let (radius, wide) = (build.number("horseshoe")?, build.number("width")? / 2.0);
        let (half, length) = (build.number("angle")? / 2.0, build.number("length")?);
        if wide >= radius {
            let problem = format!("`width` must be less than twice the radius, {}", 2.0 * radius);
            return Err(build.wrong("width", problem).help("a narrower horseshoe"));
        }
        let [right, left] = [90.0 - half, 90.0 + half].map(|degrees| polar(1.0, degrees));
        // Straight on from the ends of the bend; they would meet in the middle.
        let (on_right, on_left) = (-right.perp() * length, left.perp() * length);
        let inmost = [right * (radius - wide) + on_right, right * (radius + wide) + on_right];
        if half > 90.0 && inmost.iter().any(|end| end.x <= 0.0) {
            return Err(build
                .wrong("length", "the ends of the horseshoe meet")
                .help("shorter ends, or a smaller angle"));
        }
        let (inner, outer) = (radius - wide, radius + wide);
        let mut outline = Outline::new();
        outline
            .line(right * outer + on_right)
            .line(right * outer)
            .arc(left * outer, DVec2::ZERO, true)
            .line(left * outer + on_left)
            .line(left * inner + on_left)
            .line(left * inner)
            .arc(right * inner, DVec2::ZERO, false)
            .line(right * inner + on_right)
            .close();
        Ok(flat(build, outline))
    },
    ..Spec::PLAIN
};
