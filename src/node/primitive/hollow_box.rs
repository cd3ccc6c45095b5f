//! A closed box with a hollow in it.

use crate::field::Aabb;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A closed box with a hollow in it.
pub const NODE: Spec = Spec {
    key: Key::new(
        "hollow_box",
        Kind::Lengths,
        Required,
        "Closed box around the origin with a hollow in it: its outer edge lengths; one number is a cube.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    parameters: &[Key::length("wall", Number(0.1), "The thickness of its walls.")],
    formula: "min(outer box, −inner box), both signed distances",
    example: "hollow_box = [1.6, 1.2, 0.8]\nwall = 0.15\nbounds = { box = [[-1, 0, -1], [1, 1, 1]], cut = true }",
    build: |build| {
        let (edges, wall) = (build.vector("hollow_box")?, build.number("wall")?);
        if 2.0 * wall >= edges.min_element() {
            let most = edges.min_element() / 2.0;
            let problem = format!("`wall` must be less than half of the shortest edge, {most}");
            return Err(build.wrong("wall", problem).help("a thinner wall, or `box`"));
        }
        let graph = build.graph();
        let (outer, inner) = (graph.cuboid(edges), graph.cuboid(edges - 2.0 * wall));
        let inner = graph.neg(inner);
        let node = graph.min(outer, inner);
        // Exact on both sides: the two boundaries do not meet.
        Ok(graph.exact(node, Aabb::new(-edges / 2.0, edges / 2.0)))
    },
    ..Spec::PLAIN
};
