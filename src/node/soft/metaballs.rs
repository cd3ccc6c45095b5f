//! Soft balls that flow together.

use crate::field::{Aabb, Node};
use crate::node::kernels::{balls, from_point, softly};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// Soft balls that flow together.
pub const NODE: Spec = Spec {
    key: Key::new(
        "metaballs",
        Kind::Rows(1, &[4]),
        Required,
        "Soft balls that flow together: of each `[x, y, z, radius]`, beyond which it has no effect.",
    )
    .unit("units"),
    parameters: &[Key::new(
        "threshold",
        Kind::Number,
        Number(0.3),
        "Where the surface lies: 0 at the radius of a ball alone, 1 at its centre.",
    )
    .limit(Limit::Within(0.001, 0.999))],
    formula: "Σ max(1 − |p − c|²/r², 0)³ − t, times half of the least r",
    source: "Wyvill, McPheeters and Wyvill, Data structure for soft objects, 1986",
    example: "metaballs = [[-0.5, 0, 0, 0.9], [0.5, 0.2, 0.1, 0.8], [0.1, -0.3, 0.7, 0.6]]",
    build: |build| {
        let (balls, threshold) = (balls(build, "metaballs")?, build.number("threshold")?);
        let graph = build.graph();
        let zero = graph.constant(0.0);
        let parts = balls.iter().map(|(centre, radius)| {
            let square = from_point(graph, *centre, *radius);
            let rest = graph.linear(square, -1.0, 1.0);
            let rest = graph.max(rest, zero);
            graph.pow(rest, 3.0)
        });
        let parts: Vec<Node> = parts.collect();
        let reach = balls.iter().map(|(centre, radius)| Aabb::new(*centre, *centre).grown(*radius));
        let bounds = reach.reduce(Aabb::union).expect("there is one");
        let least = balls.iter().fold(f64::INFINITY, |least, (_, radius)| least.min(*radius));
        Ok(softly(graph, &parts, threshold, least / 2.0, bounds))
    },
    ..Spec::PLAIN
};
