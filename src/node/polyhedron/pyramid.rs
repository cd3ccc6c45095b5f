//! A pyramid over a regular polygon.

use glam::DVec3;

use crate::node::profile::{convex, regular};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Of, Required};
use crate::text::key::{Key, Kind, Limit};

/// A pyramid over a regular polygon.
pub const NODE: Spec = Spec {
    key: Key::length(
        "pyramid",
        Required,
        "Pyramid along z over a regular polygon, around the origin: the distance from its axis to the polygon's corners.",
    ),
    parameters: &[
        Key::new("sides", Kind::Whole, Number(4.0), "How many corners the polygon has.")
            .limit(Limit::Within(3.0, 64.0)),
        Key::length("height", Of("pyramid", 1.2), "From its base to its tip."),
    ],
    formula: "the signed distance to it",
    example: "pyramid = 1",
    build: |build| {
        let (radius, sides, height) = (build.number("pyramid")?, build.whole("sides"), build.number("height")?);
        let half = height / 2.0;
        let base = regular(sides, radius).into_iter().map(|corner| corner.extend(-half));
        let corners: Vec<DVec3> = base.chain([DVec3::Z * half]).collect();
        convex(build, "pyramid", &corners)
    },
    ..Spec::PLAIN
};
