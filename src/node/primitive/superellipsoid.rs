//! A superellipsoid: between box, ellipsoid and octahedron.

use glam::DVec3;

use crate::field::Aabb;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A superellipsoid: between box, ellipsoid and octahedron.
pub const NODE: Spec = Spec {
    key: Key::new("superellipsoid", Kind::Lengths, Required, "A superellipsoid around the origin: its half axes.")
        .limit(Limit::Positive)
        .unit("units"),
    parameters: &[
        Key::new(
            "squareness_z",
            Kind::Number,
            Number(0.5),
            "Its outline seen from the side: towards 0 a rectangle, 1 an ellipse, 2 a rhombus.",
        )
        .limit(Limit::Within(0.1, 2.0)),
        Key::new("squareness_xy", Kind::Number, Number(0.5), "Its outline seen from above, likewise.")
            .limit(Limit::Within(0.1, 2.0)),
    ],
    formula: "(1 − ((|x/a|^(2/e) + |y/b|^(2/e))^(e/n) + |z/c|^(2/n))^(n/2))·min(a, b, c), n = squareness_z, e = squareness_xy",
    source: "Barr, Superquadrics and Angle-Preserving Transformations, 1981",
    example: "superellipsoid = [1, 0.8, 0.6]",
    build: |build| {
        let half = build.vector("superellipsoid")?;
        let (side, above) = (build.number("squareness_z")?, build.number("squareness_xy")?);
        let graph = build.graph();
        // A power below 1 has no slope at 0: this far from it, nobody sees it.
        let least = graph.constant(1e-24);
        let [x, y, z] = [(DVec3::X, half.x, above), (DVec3::Y, half.y, above), (DVec3::Z, half.z, side)].map(
            |(axis, half, squareness)| {
                let share = graph.affine(axis / half, 0.0);
                let share = graph.abs(share);
                graph.pow(share, 2.0 / squareness)
            },
        );
        let across = graph.add(x, y);
        let across = graph.max(across, least);
        let across = graph.pow(across, above / side);
        let sum = graph.add(across, z);
        let sum = graph.max(sum, least);
        let size = graph.pow(sum, side / 2.0);
        let scale = half.min_element();
        let node = graph.linear(size, -scale, scale);
        Ok(graph.bounded(node, Aabb::new(-half, half)))
    },
    ..Spec::PLAIN
};
