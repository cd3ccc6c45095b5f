//! A prism over a regular polygon.

use glam::{DVec2, DVec3};

use crate::field::Aabb;
use crate::node::profile::regular;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Of, Required};
use crate::text::key::{Key, Kind, Limit};

/// A prism over a regular polygon.
pub const NODE: Spec = Spec {
    key: Key::length(
        "prism",
        Required,
        "Prism along z over a regular polygon, around the origin: the distance from its axis to the polygon's corners.",
    ),
    parameters: &[
        Key::new("sides", Kind::Whole, Number(6.0), "How many corners the polygon has.")
            .limit(Limit::Within(3.0, 64.0)),
        Key::length("height", Of("prism", 1.5), "From its bottom to its top."),
    ],
    formula: "the signed distance to it",
    example: "prism = 0.8",
    build: |build| {
        let (radius, sides, height) = (build.number("prism")?, build.whole("sides"), build.number("height")?);
        let corners = regular(sides, radius);
        let edges: Vec<[DVec2; 2]> =
            (0..corners.len()).map(|i| [corners[i], corners[(i + 1) % corners.len()]]).collect();
        let graph = build.graph();
        let (x, y, caps) = (graph.x(), graph.y(), graph.slab(DVec3::Z, height));
        let section = graph.convex_polygon([x, y], &edges);
        let node = graph.corner(section, caps);
        let half = DVec3::new(radius, radius, height / 2.0);
        Ok(graph.exact(node, Aabb::new(-half, half)))
    },
    ..Spec::PLAIN
};
