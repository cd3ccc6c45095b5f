//! A ridge where a surface meets another.

use crate::node::blending::two_distances;
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind};

/// A ridge where a surface meets another.
pub const NODE: Spec = Spec {
    key: Key::new(
        "tongue",
        Kind::TwoShapes,
        Required,
        "The first, with a ridge on it where the surface of the second meets its own.",
    ),
    parameters: &[
        Key::length("tongue_height", Number(0.1), "How high it is."),
        Key::length("tongue_width", Number(0.1), "How wide it is."),
    ],
    formula: "max(a, min(a + d, w/2 − |b|))",
    source: "Mercury, hg_sdf: fOpTongue",
    example: "tongue = [\"a\", \"b\"]",
    carries: Carries::First,
    measures: |_| true,
    build: |build| {
        let (depth, width) = (build.number("tongue_height")?, build.number("tongue_width")?);
        let most = build.ever("tongue_height")?.hi.max(build.ever("tongue_width")?.hi / 2.0);
        let [a, b] = two_distances(build, "tongue", "tongue_height", most)?;
        let graph = build.graph();
        let apart = graph.abs(b);
        let (higher, beside) = (graph.linear(a, 1.0, depth), graph.linear(apart, -1.0, width / 2.0));
        let ridge = graph.min(higher, beside);
        let node = graph.max(a, ridge);
        Ok(match graph.known_box(a) {
            Some(aabb) => graph.bounded(node, aabb.grown(crate::node::measured::SLACK * depth)),
            None => node,
        })
    },
    ..Spec::PLAIN
};
