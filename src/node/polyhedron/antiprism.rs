//! Two polygons turned against one another, joined by triangles.

use glam::DVec3;

use crate::node::profile::{convex, polar, regular};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Of, Required};
use crate::text::key::{Key, Kind, Limit};

/// Two polygons turned against one another, joined by triangles.
pub const NODE: Spec = Spec {
    key: Key::length(
        "antiprism",
        Required,
        "Antiprism along z around the origin, two regular polygons turned against one another and joined by triangles: the distance from its axis to their corners.",
    ),
    parameters: &[
        Key::new("sides", Kind::Whole, Number(5.0), "How many corners each polygon has.")
            .limit(Limit::Within(3.0, 64.0)),
        Key::length("height", Of("antiprism", 1.2), "From its bottom to its top."),
    ],
    formula: "the signed distance to it",
    example: "antiprism = 0.8",
    build: |build| {
        let (radius, sides, height) = (build.number("antiprism")?, build.whole("sides"), build.number("height")?);
        let half = height / 2.0;
        let turned = (0..sides).map(|i| polar(radius, 90.0 + 360.0 * (i as f64 + 0.5) / sides as f64).extend(-half));
        let corners: Vec<DVec3> =
            regular(sides, radius).into_iter().map(|corner| corner.extend(half)).chain(turned).collect();
        convex(build, "antiprism", &corners)
    },
    ..Spec::PLAIN
};
