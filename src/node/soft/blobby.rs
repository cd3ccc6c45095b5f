//! Blinn's blobs.

use crate::field::{Aabb, Node};
use crate::node::kernels::{balls, from_point, softly};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind};

/// Blinn's blobs.
pub const NODE: Spec = Spec {
    key: Key::new(
        "blobby",
        Kind::Rows(1, &[4]),
        Required,
        "Blinn's blobs, soft balls of Gaussian density: of each `[x, y, z, radius]` that it has alone.",
    )
    .unit("units"),
    parameters: &[Key::length(
        "blobbiness",
        Number(1.0),
        "How sharply they end: less, and they flow together from farther away.",
    )],
    formula: "(Σ exp(b·(1 − |p − c|²/r²)) − 1)·r/(2b), r the least radius",
    source: "Blinn, A Generalization of Algebraic Surface Drawing, 1982",
    example: "blobby = [[-0.5, 0, 0, 0.6], [0.5, 0.2, 0.1, 0.5], [0.1, -0.3, 0.7, 0.4]]",
    build: |build| {
        let (balls, sharp) = (balls(build, "blobby")?, build.number("blobbiness")?);
        let graph = build.graph();
        let parts: Vec<Node> = balls
            .iter()
            .map(|(centre, radius)| {
                let square = from_point(graph, *centre, *radius);
                let power = graph.linear(square, -sharp, sharp);
                graph.exp(power)
            })
            .collect();
        // Where all together are 1 if each were as near as the nearest.
        let far = (1.0 + libm::log(balls.len() as f64) / sharp).sqrt();
        let reach = balls.iter().map(|(centre, radius)| Aabb::new(*centre, *centre).grown(*radius * far));
        let bounds = reach.reduce(Aabb::union).expect("there is one");
        let least = balls.iter().fold(f64::INFINITY, |least, (_, radius)| least.min(*radius));
        Ok(softly(graph, &parts, 1.0, least / (2.0 * sharp), bounds))
    },
    ..Spec::PLAIN
};
