//! A pipe.

use glam::DVec3;

use crate::field::Aabb;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// A pipe.
pub const NODE: Spec = Spec {
    key: Key::length("pipe", Required, "Pipe along z around the origin, open at both ends: its outer radius."),
    parameters: &[
        Key::length("wall", Of("pipe", 0.2), "The thickness of its wall."),
        Key::length("height", Of("pipe", 2.0), "From its bottom to its top."),
    ],
    formula: "the signed distance to it",
    example: "pipe = 0.6",
    build: |build| {
        let (radius, wall, height) = (build.number("pipe")?, build.number("wall")?, build.number("height")?);
        if wall >= radius {
            let problem = format!("`wall` must be less than the radius, {radius}");
            return Err(build.wrong("wall", problem).help("a thinner wall, or `cylinder`"));
        }
        let graph = build.graph();
        let across = graph.radius_about_z();
        let (outer, inner) = (graph.linear(across, -1.0, radius), graph.linear(across, 1.0, wall - radius));
        let (ring, caps) = (graph.min(outer, inner), graph.slab(DVec3::Z, height));
        let node = graph.corner(ring, caps);
        let half = DVec3::new(radius, radius, height / 2.0);
        Ok(graph.exact(node, Aabb::new(-half, half)))
    },
    ..Spec::PLAIN
};
