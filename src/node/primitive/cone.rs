//! A cone, or one whose top is cut off.

use glam::{DVec2, DVec3};

use crate::field::Aabb;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Of, Required};
use crate::text::key::{Key, Kind, Limit};

/// A cone, or one whose top is cut off.
pub const NODE: Spec = Spec {
    key: Key::length("cone", Required, "A cone along z around the origin: the radius of its base, which is below.")
        .also(&["capped_cone"]),
    parameters: &[
        Key::length("height", Of("cone", 2.0), "From its base to its top."),
        Key::new("top", Kind::Number, Number(0.0), "The radius of its top; 0 is a point.")
            .limit(Limit::NotNegative)
            .unit("units"),
    ],
    formula: "the signed distance to it",
    example: "cone = 0.8",
    build: |build| {
        let (base, top, half) = (build.number("cone")?, build.number("top")?, build.number("height")? / 2.0);
        let graph = build.graph();
        let (x, y, z) = (graph.x(), graph.y(), graph.z());
        let across = graph.length(&[x, y]);
        // Counterclockwise in (ρ, z), but for the axis.
        let [low, rim, edge, high] = [(0.0, -half), (base, -half), (top, half), (0.0, half)].map(DVec2::from);
        let edges = [[low, rim], [rim, edge], [edge, high]];
        let edges = if top > 0.0 { &edges[..] } else { &edges[..2] };
        let cone = graph.convex_polygon([across, z], edges);
        let reach = base.max(top);
        let half = DVec3::new(reach, reach, half);
        Ok(graph.exact(cone, Aabb::new(-half, half)))
    },
    ..Spec::PLAIN
};
