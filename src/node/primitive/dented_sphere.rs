//! A ball with a round dent.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::revolved;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// A ball with a round dent.
pub const NODE: Spec = Spec {
    key: Key::length("dented_sphere", Required, "Ball around the origin with a round dent at its top: its radius.")
        .also(&["death_star"]),
    parameters: &[
        Key::length("dent", Of("dented_sphere", 0.8), "The radius of the ball that is taken away."),
        Key::length("dent_height", Of("dented_sphere", 1.2), "The z of the centre of that ball."),
    ],
    formula: "the signed distance to it",
    example: "dented_sphere = 1",
    build: |build| {
        let radius = build.number("dented_sphere")?;
        let (dent, up) = (build.number("dent")?, build.number("dent_height")?);
        if up >= radius + dent || up <= (radius - dent).abs() {
            let (least, most) = ((radius - dent).abs(), radius + dent);
            let problem = format!("the two balls must cross: `dent_height` between {least} and {most}");
            return Err(build.wrong("dent_height", problem).help("`difference` cuts anything from anything"));
        }
        let height = (radius * radius - dent * dent + up * up) / (2.0 * up);
        let rim = DVec2::new((radius * radius - height * height).max(0.0).sqrt(), height);
        let mut outline = Outline::new();
        outline
            .line(DVec2::NEG_Y * radius)
            .arc(rim, DVec2::ZERO, true)
            .arc(DVec2::Y * (up - dent), DVec2::Y * up, false)
            .close();
        Ok(revolved(build, outline))
    },
    ..Spec::PLAIN
};
