//! A rectangle.

use glam::{DVec2, DVec3};

use crate::field::{Aabb, Graph, Node};
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind, Limit};

/// A rectangle.
pub const NODE: Spec = Spec {
    key: Key::new(
        "rectangle",
        Kind::Pair,
        Required,
        "Rectangle around the origin: its edge lengths; one number is a square.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    formula: "the signed distance to it",
    example: "rectangle = [1.6, 1]",
    plane: Plane::Flat,
    build: |build| {
        let edges = build.pair("rectangle")?;
        Ok(rectangle(build.graph(), edges, 0.0))
    },
    ..Spec::PLAIN
};

/// A rectangle by its edges and the radius of its corners.
pub(super) fn rectangle(graph: &mut Graph, edges: DVec2, radius: f64) -> Node {
    let core = edges - 2.0 * radius;
    let (x, y) = (graph.slab(DVec3::X, core.x), graph.slab(DVec3::Y, core.y));
    let node = graph.corner(x, y);
    let node = graph.linear(node, 1.0, radius);
    let half = (edges / 2.0).extend(0.0);
    graph.exact(node, Aabb::new(-half, half).without_z())
}
