//! A supertoroid: a ring between round and square.

use glam::DVec3;

use crate::field::Aabb;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A supertoroid: a ring between round and square.
pub const NODE: Spec = Spec {
    key: Key::new(
        "supertoroid",
        Kind::Pair,
        Required,
        "A ring around the z axis: the half axes of the middle line of its tube along x and y.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    parameters: &[
        Key::new("tube", Kind::Number, Number(0.3), "The half width of the tube, along x and y, of the half axes.")
            .limit(Limit::Within(0.001, 0.999)),
        Key::length("tube_height", Number(0.25), "The half height of the tube, along z."),
        Key::new(
            "squareness_z",
            Kind::Number,
            Number(0.5),
            "The outline of its tube: towards 0 a rectangle, 1 an ellipse, 2 a rhombus.",
        )
        .limit(Limit::Within(0.1, 2.0)),
        Key::new("squareness_xy", Kind::Number, Number(0.5), "The outline of the ring seen from above, likewise.")
            .limit(Limit::Within(0.1, 2.0)),
    ],
    formula: "(1 − ((|ρ − 1|/w)^(2/n) + |z/c|^(2/n))^(n/2))·min(w·a, w·b, c), ρ = (|x/a|^(2/e) + |y/b|^(2/e))^(e/2), n = squareness_z, e = squareness_xy",
    source: "Barr, Superquadrics and Angle-Preserving Transformations, 1981",
    example: "supertoroid = [0.8, 0.7]\nsquareness_xy = 0.3\nsquareness_z = 1.5",
    build: |build| {
        let half = build.pair("supertoroid")?;
        let [tube, height] = [build.number("tube")?, build.number("tube_height")?];
        let (side, above) = (build.number("squareness_z")?, build.number("squareness_xy")?);
        let graph = build.graph();
        // A power below 1 has no slope at 0: this far from it, nobody sees it.
        let least = graph.constant(1e-24);
        let [x, y] = [(DVec3::X, half.x), (DVec3::Y, half.y)].map(|(axis, half)| {
            let share = graph.affine(axis / half, 0.0);
            let share = graph.abs(share);
            graph.pow(share, 2.0 / above)
        });
        let across = graph.add(x, y);
        let across = graph.max(across, least);
        let ring = graph.pow(across, above / 2.0);
        let away = graph.linear(ring, 1.0 / tube, -1.0 / tube);
        let up = graph.affine(DVec3::Z / height, 0.0);
        let [away, up] = [away, up].map(|share| {
            let share = graph.abs(share);
            graph.pow(share, 2.0 / side)
        });
        let sum = graph.add(away, up);
        let sum = graph.max(sum, least);
        let size = graph.pow(sum, side / 2.0);
        let scale = (tube * half.min_element()).min(height);
        let node = graph.linear(size, -scale, scale);
        let reach = half * (1.0 + tube);
        let corner = DVec3::new(reach.x, reach.y, height);
        Ok(graph.bounded(node, Aabb::new(-corner, corner)))
    },
    ..Spec::PLAIN
};
