//! A groove cut where a surface meets another.

use crate::node::blending::two_distances;
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind};

/// A groove cut where a surface meets another.
pub const NODE: Spec = Spec {
    key: Key::new(
        "groove",
        Kind::TwoShapes,
        Required,
        "The first, with a groove cut into it where the surface of the second meets its own.",
    ),
    parameters: &[
        Key::length("groove_depth", Number(0.1), "How deep it is."),
        Key::length("groove_width", Number(0.1), "How wide it is."),
    ],
    formula: "min(a, max(a − d, |b| − w/2))",
    source: "Mercury, hg_sdf: fOpGroove",
    example: "groove = [\"a\", \"b\"]",
    carries: Carries::First,
    measures: |_| true,
    build: |build| {
        let (depth, width) = (build.number("groove_depth")?, build.number("groove_width")?);
        let most = build.ever("groove_depth")?.hi.max(build.ever("groove_width")?.hi / 2.0);
        let [a, b] = two_distances(build, "groove", "groove_depth", most)?;
        let graph = build.graph();
        let apart = graph.abs(b);
        let (deeper, beside) = (graph.linear(a, 1.0, -depth), graph.linear(apart, 1.0, -width / 2.0));
        let rest = graph.max(deeper, beside);
        let node = graph.min(a, rest);
        Ok(match graph.known_box(a) {
            Some(aabb) => graph.bounded(node, aabb),
            None => node,
        })
    },
    ..Spec::PLAIN
};
