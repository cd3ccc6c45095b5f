//! Two pyramids base to base.

use glam::DVec3;

use crate::node::profile::{convex, regular};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Of, Required};
use crate::text::key::{Key, Kind, Limit};

/// Two pyramids base to base.
pub const NODE: Spec = Spec {
    key: Key::length(
        "bipyramid",
        Required,
        "Two pyramids over a regular polygon, base to base in the xy plane: the distance from its centre to the polygon's corners.",
    ),
    parameters: &[
        Key::new("sides", Kind::Whole, Number(6.0), "How many corners the polygon has.")
            .limit(Limit::Within(3.0, 64.0)),
        Key::length("height", Of("bipyramid", 2.0), "From tip to tip."),
    ],
    formula: "the signed distance to it",
    example: "bipyramid = 0.7",
    build: |build| {
        let (radius, sides, height) = (build.number("bipyramid")?, build.whole("sides"), build.number("height")?);
        let tip = DVec3::Z * (height / 2.0);
        let corners: Vec<DVec3> =
            regular(sides, radius).into_iter().map(|corner| corner.extend(0.0)).chain([tip, -tip]).collect();
        convex(build, "bipyramid", &corners)
    },
    ..Spec::PLAIN
};
