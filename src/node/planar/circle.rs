//! A disc.

use glam::DVec3;

use crate::field::Aabb;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// A disc.
pub const NODE: Spec = Spec {
    key: Key::length("circle", Required, "Disc around the origin: its radius."),
    formula: "r − |(x, y)|",
    example: "circle = 1",
    plane: Plane::Flat,
    build: |build| {
        let radius = build.number("circle")?;
        let graph = build.graph();
        let across = graph.radius_about_z();
        let node = graph.linear(across, -1.0, radius);
        let half = DVec3::splat(radius);
        Ok(graph.exact(node, Aabb::new(-half, half).without_z()))
    },
    ..Spec::PLAIN
};
