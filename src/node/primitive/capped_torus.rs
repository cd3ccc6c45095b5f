//! A piece of a torus with round ends.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};

use crate::field::{Aabb, Joined, Procedure, Slope};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Of, Required};
use crate::text::key::{Key, Kind, Limit};

/// A piece of a torus with round ends.
pub const NODE: Spec = Spec {
    key: Key::length("capped_torus", Required, "Piece of a torus around the z axis, its ends round: major radius."),
    parameters: &[
        Key::length("tube", Of("capped_torus", 0.2), "The radius of its tube."),
        Key::new("angle", Kind::Number, Number(240.0), "How far it goes round, its middle on the x axis.")
            .limit(Limit::Within(0.1, 359.9))
            .unit("degrees"),
    ],
    formula: "s − |p − q|, q the nearest of the arc",
    example: "capped_torus = 0.8",
    build: |build| {
        let (radius, tube) = (build.number("capped_torus")?, build.number("tube")?);
        let half = build.number("angle")?.to_radians() / 2.0;
        let end = DVec2::new(libm::cos(half), libm::sin(half)) * radius;
        let at = move |p: DVec3| {
            let folded = DVec2::new(p.x, p.y.abs());
            // Beyond the end's direction, as seen from the axis, the end is nearest.
            let beyond = end.perp_dot(folded) > 0.0 || (half < FRAC_PI_2 && folded.x < 0.0);
            let flat = if beyond && (half <= FRAC_PI_2 || folded.x < 0.0) {
                end
            } else {
                folded.normalize_or(DVec2::X) * radius
            };
            let nearest = DVec3::new(flat.x, if p.y < 0.0 { -flat.y } else { flat.y }, 0.0);
            let away = p - nearest;
            let distance = away.length();
            (tube - distance, -away.normalize_or(DVec3::Z))
        };
        let reach = DVec3::new(radius, if half < FRAC_PI_2 { end.y } else { radius }, 0.0);
        let bounds = Aabb::new(DVec3::new(end.x.min(radius), -reach.y, 0.0), reach).grown(tube);
        // Inside is exact where the tube neither meets itself nor its other end.
        let gap = if half > FRAC_PI_2 { end.y } else { radius };
        let slope = Slope::Exact { outside: true, inside: tube <= radius.min(gap) };
        let torus = Procedure { at, bounds: Some(bounds), slope, is_flat: false };
        Ok(build.graph().field(Joined::shared(torus)))
    },
    ..Spec::PLAIN
};
