//! A cylinder with round edges.

use glam::DVec3;

use crate::field::Aabb;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// A cylinder with round edges.
pub const NODE: Spec = Spec {
    key: Key::length("rounded_cylinder", Required, "Cylinder along z around the origin with round edges: its radius."),
    parameters: &[
        Key::length("height", Of("rounded_cylinder", 2.0), "From its bottom to its top."),
        Key::length("edge_radius", Of("rounded_cylinder", 0.2), "The radius of its edges."),
    ],
    formula: "the signed distance to it",
    example: "rounded_cylinder = 0.6",
    build: |build| {
        let (radius, height) = (build.number("rounded_cylinder")?, build.number("height")?);
        let edge = build.number("edge_radius")?;
        if edge > radius || 2.0 * edge > height {
            let most = radius.min(height / 2.0);
            let problem = format!("`edge_radius` must be at most {most}: the radius and half of the height");
            return Err(build.wrong("edge_radius", problem).help("a smaller edge, or a larger cylinder"));
        }
        let graph = build.graph();
        let core = graph.cylinder(radius - edge, height - 2.0 * edge);
        let node = graph.linear(core, 1.0, edge);
        let half = DVec3::new(radius, radius, height / 2.0);
        Ok(graph.exact(node, Aabb::new(-half, half)))
    },
    ..Spec::PLAIN
};
