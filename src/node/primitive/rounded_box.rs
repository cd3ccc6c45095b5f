//! A box with round edges.

use crate::field::Aabb;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A box with round edges.
pub const NODE: Spec = Spec {
    key: Key::new(
        "rounded_box",
        Kind::Lengths,
        Required,
        "Box around the origin with round edges and corners: its edge lengths; one number is a cube.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    parameters: &[Key::length("edge_radius", Number(0.1), "The radius of its edges.")],
    formula: "the signed distance to it",
    example: "rounded_box = [1.6, 1.2, 0.8]\nedge_radius = 0.2",
    build: |build| {
        let (edges, radius) = (build.vector("rounded_box")?, build.number("edge_radius")?);
        if 2.0 * radius > edges.min_element() {
            let most = edges.min_element() / 2.0;
            let problem = format!("`edge_radius` is more than half of the shortest edge, {most}");
            return Err(build.wrong("edge_radius", problem).help("a smaller radius, or longer edges"));
        }
        let graph = build.graph();
        // Grown from a box, whose distance inside is exact too: the faces of both are parallel.
        let core = graph.cuboid(edges - 2.0 * radius);
        let node = graph.linear(core, 1.0, radius);
        Ok(graph.exact(node, Aabb::new(-edges / 2.0, edges / 2.0)))
    },
    ..Spec::PLAIN
};
