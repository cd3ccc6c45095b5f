//! Barth's decic.

use glam::DVec3;

use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// Barth's decic.
pub const NODE: Spec = Spec {
    key: Key::length(
        "barth_decic",
        Required,
        "Barth's decic around the origin, a surface of degree 10 with 345 double points: the radius of the ball that cuts it off.",
    ),
    formula: "−8(x² − φ⁴y²)(y² − φ⁴z²)(z² − φ⁴x²)(x⁴ + y⁴ + z⁴ − 2x²y² − 2y²z² − 2z²x²) − (3 + 5φ)(q − 1)²(q − 2 + φ)², q = x² + y² + z², φ the golden ratio, cut off by a ball",
    source: "Barth, Two projective surfaces with many nodes admitting the symmetries of the icosahedron, 1996",
    example: "barth_decic = 1",
    build: |build| {
        let radius = build.number("barth_decic")?;
        let graph = build.graph();

        /// The ball's radius in the surface's own units.
        const REACH: f64 = 1.45;
        /// Makes the value about as steep as a distance.
        const SCALE: f64 = 0.02;
        let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
        let fourth = (golden * golden) * (golden * golden);
        let squares = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| {
            let share = graph.affine(axis * (REACH / radius), 0.0);
            graph.square(share)
        });
        let [x, y, z] = squares;
        let product = [(x, y), (y, z), (z, x)].map(|(first, second)| {
            let second = graph.linear(second, fourth, 0.0);
            graph.sub(first, second)
        });
        let product = product.into_iter().reduce(|a, b| graph.mul(a, b)).expect("there are three");
        // x⁴ + y⁴ + z⁴ − 2(x²y² + y²z² + z²x²) = (x² + y² − z²)² − 4x²y².
        let flat = graph.add(x, y);
        let sum = graph.add(flat, z);
        let flat = graph.sub(flat, z);
        let (flat, both) = (graph.square(flat), graph.mul(x, y));
        let both = graph.linear(both, 4.0, 0.0);
        let flat = graph.sub(flat, both);
        let product = graph.mul(product, flat);
        let (outer, inner) = (graph.linear(sum, 1.0, -1.0), graph.linear(sum, 1.0, golden - 2.0));
        let ball = graph.mul(outer, inner);
        let ball = graph.square(ball);
        let scale = SCALE * radius;
        let (ball, product) =
            (graph.linear(ball, scale * (3.0 + 5.0 * golden), 0.0), graph.linear(product, 8.0 * scale, 0.0));
        let surface = graph.add(ball, product);
        let surface = graph.neg(surface);
        let cut = graph.sphere(radius);
        Ok(graph.min(surface, cut))
    },
    ..Spec::PLAIN
};
