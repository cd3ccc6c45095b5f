//! Barth's sextic.

use glam::DVec3;

use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// Barth's sextic.
pub const NODE: Spec = Spec {
    key: Key::length(
        "barth_sextic",
        Required,
        "Barth's sextic around the origin, a surface of degree 6 with 65 double points: the radius of the ball that cuts it off.",
    ),
    formula: "4(φ²x² − y²)(φ²y² − z²)(φ²z² − x²) − (1 + 2φ)(q − 1)², q = x² + y² + z², φ the golden ratio, cut off by a ball",
    source: "Barth, Two projective surfaces with many nodes admitting the symmetries of the icosahedron, 1996",
    example: "barth_sextic = 1",
    build: |build| {
        let radius = build.number("barth_sextic")?;
        let graph = build.graph();

        /// The ball's radius, where the surface's own has all double points within √3.
        const REACH: f64 = 1.8;
        /// Makes the value about as steep as a distance.
        const SCALE: f64 = 0.03;
        let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| {
            let share = graph.affine(axis * (REACH / radius), 0.0);
            graph.square(share)
        });
        let product = [(x, y), (y, z), (z, x)].map(|(first, second)| {
            let first = graph.linear(first, golden * golden, 0.0);
            graph.sub(first, second)
        });
        let product = product.into_iter().reduce(|a, b| graph.mul(a, b)).expect("there are three");
        let sum = graph.add(x, y);
        let sum = graph.add(sum, z);
        let ball = graph.linear(sum, 1.0, -1.0);
        let ball = graph.square(ball);
        let scale = SCALE * radius;
        let (ball, product) =
            (graph.linear(ball, scale * (1.0 + 2.0 * golden), 0.0), graph.linear(product, 4.0 * scale, 0.0));
        let surface = graph.sub(product, ball);
        let cut = graph.sphere(radius);
        Ok(graph.min(surface, cut))
    },
    ..Spec::PLAIN
};
