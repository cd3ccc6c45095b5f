//! A cylinder over an ellipse.

use std::sync::Arc;

use glam::DVec3;

use crate::field::{Aabb, Ellipse};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A cylinder over an ellipse.
pub const NODE: Spec = Spec {
    key: Key::new(
        "elliptic_cylinder",
        Kind::Pair,
        Required,
        "Cylinder along z over an ellipse, around the origin: the half axes of the ellipse along x and y.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    parameters: &[Key::length("height", Number(1.0), "From its bottom to its top.")],
    formula: "the signed distance to it, the nearest point of the ellipse found by iteration",
    example: "elliptic_cylinder = [0.9, 0.5]",
    build: |build| {
        let (half, height) = (build.pair("elliptic_cylinder")?, build.number("height")?);
        let graph = build.graph();
        let (section, caps) = (graph.field(Arc::new(Ellipse::new(half.to_array()))), graph.slab(DVec3::Z, height));
        let node = graph.corner(section, caps);
        let half = half.extend(height / 2.0);
        Ok(graph.exact(node, Aabb::new(-half, half)))
    },
    ..Spec::PLAIN
};
