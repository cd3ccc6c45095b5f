//! A ring.

use glam::DVec3;

use crate::field::Aabb;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// A ring.
pub const NODE: Spec = Spec {
    key: Key::length("ring", Required, "Ring around the origin: its outer radius."),
    parameters: &[Key::length("width", Of("ring", 0.3), "Its width.")],
    formula: "min(r − |(x, y)|, |(x, y)| − r + w)",
    example: "ring = 1",
    plane: Plane::Flat,
    build: |build| {
        let (radius, width) = (build.number("ring")?, build.number("width")?);
        if width >= radius {
            let problem = format!("`width` must be less than the radius, {radius}");
            return Err(build.wrong("width", problem).help("a narrower ring, or `circle`"));
        }
        let graph = build.graph();
        let across = graph.radius_about_z();
        let (outer, inner) = (graph.linear(across, -1.0, radius), graph.linear(across, 1.0, width - radius));
        let node = graph.min(outer, inner);
        let half = DVec3::splat(radius);
        Ok(graph.exact(node, Aabb::new(-half, half).without_z()))
    },
    ..Spec::PLAIN
};
