//! A tube where two surfaces meet.

use crate::node::blending::{around_both, steepest, two_distances};
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind};

/// A tube where two surfaces meet.
pub const NODE: Spec = Spec {
    key: Key::new(
        "seam_pipe",
        Kind::TwoShapes,
        Required,
        "A tube along the curve where the surfaces of two shapes meet.",
    ),
    parameters: &[Key::length("pipe_radius", Number(0.1), "Its radius, where they meet at a right angle.")],
    formula: "r − |(a, b)|",
    source: "Mercury, hg_sdf: fOpPipe",
    example: "seam_pipe = [\"a\", \"b\"]\npipe_radius = 0.2",
    carries: Carries::Blend,
    measures: |_| true,
    build: |build| {
        let (radius, most) = (build.number("pipe_radius")?, build.ever("pipe_radius")?.hi);
        let [a, b] = two_distances(build, "seam_pipe", "pipe_radius", most)?;
        let graph = build.graph();
        let steep = steepest(graph, [a, b]);
        let far = graph.length(&[a, b]);
        let node = graph.linear(far, -1.0, radius);
        let node = steep.map_or(node, |bound| graph.no_steeper(node, bound * std::f64::consts::SQRT_2));
        Ok(around_both(graph, node, [a, b], radius))
    },
    ..Spec::PLAIN
};
