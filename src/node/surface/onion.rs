//! Walls within one another.

use crate::field::Interval;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Nothing, Number, Of};
use crate::text::key::{Key, Kind, Limit};

/// Walls within one another.
pub const NODE: Spec = Spec {
    key: Key::new("onion", Kind::Whole, Nothing, "So many walls within one another, the outermost at the surface.")
        .limit(Limit::Within(1.0, 100.0)),
    parameters: &[
        Key::length("layer", Number(0.05), "The thickness of each."),
        Key::length("layer_gap", Of("layer", 1.0), "How far each is from the next."),
    ],
    formula: "max over i of min(f − i·(t + g), i·(t + g) + t − f), f the signed distance",
    source: "Quilez, Distance functions: onion",
    example: "sphere = 1\nonion = 3\nlayer = 0.1",
    measures: |_| true,
    build: |build| {
        let solid = build.inner()?;
        let count = build.arguments().whole("onion").map_or(1, |count| (*count).max(1));
        let (layer, gap) = (build.number("layer")?, build.number("layer_gap")?);
        // What a layer's default refers to may change over time: as it does at its most.
        let most = build.ever("layer")?.hi.max(layer) + gap;
        let distance = build.distance(solid, Interval::new(0.0, most * count as f64), "onion")?;
        let graph = build.graph();
        let wall = |graph: &mut crate::field::Graph, at: f64| {
            let (outer, inner) = (graph.linear(distance, 1.0, -at), graph.linear(distance, -1.0, at + layer));
            graph.min(outer, inner)
        };
        let walls: Vec<_> = (0..count).map(|i| wall(graph, i as f64 * (layer + gap))).collect();
        let node = graph.union(crate::field::SetSystem::MinMax, &walls);
        Ok(build.held(node, solid, 0.0))
    },
    ..Spec::PLAIN
};
