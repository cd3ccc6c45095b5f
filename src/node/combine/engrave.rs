//! A line cut where a surface meets another.

use crate::node::blending::two_distances;
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind};

/// A line cut where a surface meets another.
pub const NODE: Spec = Spec {
    key: Key::new(
        "engrave",
        Kind::TwoShapes,
        Required,
        "The first, with a line cut into it, of a right angle, where the surface of the second meets its own.",
    ),
    parameters: &[Key::length("engrave_depth", Number(0.1), "How deep the line is.")],
    formula: "min(a, (a + |b| − r)/√2)",
    source: "Mercury, hg_sdf: fOpEngrave",
    example: "engrave = [\"a\", \"b\"]",
    carries: Carries::First,
    measures: |_| true,
    build: |build| {
        let (radius, most) = (build.number("engrave_depth")?, build.ever("engrave_depth")?.hi);
        let [a, b] = two_distances(build, "engrave", "engrave_depth", most)?;
        let graph = build.graph();
        let apart = graph.abs(b);
        let sum = graph.add(a, apart);
        let share = std::f64::consts::FRAC_1_SQRT_2;
        let cut = graph.linear(sum, share, -radius * share);
        let node = graph.min(a, cut);
        let node = match graph.known_box(a) {
            Some(aabb) => graph.bounded(node, aabb),
            None => node,
        };
        Ok(node)
    },
    ..Spec::PLAIN
};
