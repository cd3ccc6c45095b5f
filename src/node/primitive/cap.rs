//! A cap of a ball.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::revolved;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// A cap of a ball.
pub const NODE: Spec = Spec {
    key: Key::length(
        "cap",
        Required,
        "Spherical cap with a flat base below, around the origin: the radius of its base.",
    ),
    parameters: &[Key::length("height", Of("cap", 0.5), "From its base to its top.")],
    formula: "the signed distance to it",
    example: "cap = 1\nheight = 0.6",
    build: |build| {
        let (base, height) = (build.number("cap")?, build.number("height")?);
        let radius = (base * base + height * height) / (2.0 * height);
        let half = height / 2.0;
        let mut outline = Outline::new();
        outline
            .line(DVec2::NEG_Y * half)
            .line(DVec2::new(base, -half))
            .arc(DVec2::Y * half, DVec2::Y * (half - radius), true)
            .close();
        Ok(revolved(build, outline))
    },
    ..Spec::PLAIN
};
