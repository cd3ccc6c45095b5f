//! A superellipse.

use glam::DVec3;

use crate::field::Aabb;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A superellipse.
pub const NODE: Spec = Spec {
    key: Key::new(
        "superellipse",
        Kind::Pair,
        Required,
        "Superellipse around the origin, between rhombus, ellipse and rectangle: its half axes.",
    )
    .limit(Limit::Positive)
    .unit("units")
    .also(&["squircle"]),
    parameters: &[Key::new(
        "exponent",
        Kind::Number,
        Number(4.0),
        "1 a rhombus, 2 an ellipse, the more the nearer to a rectangle.",
    )
    .limit(Limit::Within(1.0, 20.0))],
    formula: "(1 − (|x/a|^n + |y/b|^n)^(1/n))·min(a, b)",
    source: "Lamé",
    example: "superellipse = [1, 0.7]",
    plane: Plane::Flat,
    build: |build| {
        let (half, exponent) = (build.pair("superellipse")?, build.number("exponent")?);
        let graph = build.graph();
        // A power below 1 has no slope at 0: this far from it, nobody sees it.
        let least = graph.constant(1e-24);
        let [x, y] = [(DVec3::X, half.x), (DVec3::Y, half.y)].map(|(axis, half)| {
            let share = graph.affine(axis / half, 0.0);
            let share = graph.abs(share);
            graph.pow(share, exponent)
        });
        let sum = graph.add(x, y);
        let sum = graph.max(sum, least);
        let size = graph.pow(sum, 1.0 / exponent);
        let scale = half.min_element();
        let node = graph.linear(size, -scale, scale);
        Ok(graph.bounded(node, Aabb::new(-half.extend(0.0), half.extend(0.0)).without_z()))
    },
    ..Spec::PLAIN
};
