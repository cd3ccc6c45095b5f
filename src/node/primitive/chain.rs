//! Links that hang in one another.

use glam::DVec3;

use crate::field::{SetSystem, Slope};
use crate::node::primitive::link;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Of, Required};
use crate::text::key::{Key, Kind, Limit};

/// Links that hang in one another.
pub const NODE: Spec = Spec {
    key: Key::length(
        "chain",
        Required,
        "Links along z that hang in one another, around the origin: the radius of their bends.",
    ),
    parameters: &[
        Key::new("links", Kind::Whole, Number(4.0), "How many links.").limit(Limit::Within(1.0, 200.0)),
        Key::length("length", Of("chain", 1.0), "The length of a link's straight parts."),
        Key::length("tube", Of("chain", 0.3), "The radius of its wire, less than half of that of the bends."),
        Key::new("play", Kind::Number, Of("tube", 0.4), "The gap between two links; 0: they touch.")
            .limit(Limit::NotNegative)
            .unit("units"),
    ],
    formula: "the greatest of the links",
    example: "chain = 0.35\nlinks = 3\ntube = 0.14",
    build: |build| {
        let (radius, length, tube) = (build.number("chain")?, build.number("length")?, build.number("tube")?);
        let (count, play) = (build.whole("links"), build.number("play")?);
        if 2.0 * tube + play > radius {
            let most = (radius - play) / 2.0;
            let problem = format!("a link's wire does not fit through the next: `tube` must be at most {most}");
            return Err(build.wrong("tube", problem).help("a thinner wire, or wider bends"));
        }
        let step = length + 2.0 * radius - 2.0 * tube - play;
        if step <= 0.0 {
            return Err(build.wrong("play", "`play` is more than the links are long").help("a smaller gap"));
        }
        let graph = build.graph();
        let link = link::upright(graph, radius, length, tube);
        let mut links = Vec::new();
        for i in 0..count {
            let up = DVec3::Z * (step * (i as f64 - (count - 1) as f64 / 2.0));
            let turned = if i % 2 == 0 { Ok(link) } else { graph.rotate(link, DVec3::Z * 90.0) };
            let moved = turned.and_then(|link| graph.translate(link, up));
            links.push(moved.expect("it is rigid"));
        }
        let chain = graph.union(SetSystem::MinMax, &links);
        // Links that do not touch are exact inside, too.
        Ok(graph.sloped(chain, Slope::Exact { outside: true, inside: play > 0.0 }, None))
    },
    ..Spec::PLAIN
};
