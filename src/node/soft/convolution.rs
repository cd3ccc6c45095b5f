//! A skeleton of lines with soft flesh.

use glam::DVec3;

use crate::field::{Aabb, Graph, Node};
use crate::node::kernels::softly;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Of, Required};
use crate::text::key::{Key, Kind, LEAST};

/// A skeleton of lines with soft flesh.
pub const NODE: Spec = Spec {
    key: Key::new(
        "convolution",
        Kind::Rows(2, &[3]),
        Required,
        "Soft flesh around a skeleton of straight lines from each point to the next, without bulges where they meet.",
    )
    .unit("units"),
    parameters: &[
        Key::length("radius", Number(0.25), "The radius around a long straight line."),
        Key::length(
            "kernel_width",
            Of("radius", 1.0),
            "How far a line's effect reaches: wider, and corners become rounder.",
        ),
    ],
    formula: "Σ ∫ (1 + |p − q|²/w²)⁻² dq over the lines, minus that of an endless line at the radius, scaled",
    source: "McCormack and Sherstyuk, Creating and rendering convolution surfaces, 1998: the Cauchy kernel",
    example: "convolution = [[-0.9, 0, -0.8], [-0.6, 0, 0.6], [0.4, 0.6, 0.6], [0.8, -0.5, -0.2]]",
    build: |build| {
        let points = build.points("convolution");
        let (radius, width) = (build.number("radius")?, build.number("kernel_width")?);
        if points.len() > MOST {
            return Err(build
                .wrong("convolution", format!("`convolution` takes at most {MOST} points"))
                .help("`polyline` takes any number"));
        }
        if points.array_windows().any(|[a, b]| a.distance(*b) < LEAST) {
            return Err(build
                .wrong("convolution", "two points that follow one another are the same")
                .help("leave one of them out"));
        }
        let spread = 1.0 / width;
        let graph = build.graph();
        let parts: Vec<Node> = points.array_windows().map(|[a, b]| line(graph, *a, *b, spread)).collect();
        // Of an endless line at the radius: π/(2s·P³).
        let solid = 1.0 + (spread * radius) * (spread * radius);
        let threshold = std::f64::consts::FRAC_PI_2 * width / (solid * solid.sqrt());
        // The slope of that, by which the value is a distance where a line goes straight on.
        let steepness = 3.0 * threshold * spread * spread * radius / solid;
        let length: f64 = points.array_windows().map(|[a, b]| a.distance(*b)).sum();
        // If all of the length were as near as the nearest of it.
        let far = ((length / threshold).sqrt() - 1.0).max(0.0).sqrt() * width;
        let bounds = points.iter().map(|p| Aabb::new(*p, *p)).reduce(Aabb::union).expect("there are two").grown(far);
        Ok(softly(graph, &parts, threshold, 1.0 / steepness, bounds))
    },
    ..Spec::PLAIN
};

/// More lines than this take long at every point.
const MOST: usize = 200;

/// The integral of the kernel along a line: with u from one end's side to the other's,
/// ∫ du/(P² + s²u²)² = u/(2P²(P² + s²u²)) + atan(su/P)/(2sP³), P² = 1 + s²·(distance from the line)².
fn line(graph: &mut Graph, a: DVec3, b: DVec3, spread: f64) -> Node {
    let along = (b - a).normalize();
    let (e, f) = along.any_orthonormal_pair();
    let across = [e, f].map(|axis| {
        let form = graph.affine(axis * spread, -axis.dot(a) * spread);
        graph.square(form)
    });
    let square = graph.add(across[0], across[1]);
    let square = graph.linear(square, 1.0, 1.0);
    let root = graph.sqrt(square);
    let cube = graph.mul(square, root);
    let ends = [(along, along.dot(a)), (-along, -along.dot(b))].map(|(axis, from)| {
        let way = graph.affine(axis * spread, -from * spread);
        let far = graph.square(way);
        let sum = graph.add(square, far);
        let below = graph.mul(square, sum);
        let fraction = graph.div(way, below);
        let angle = graph.atan2(way, root);
        let angle = graph.div(angle, cube);
        graph.add(fraction, angle)
    });
    let both = graph.add(ends[0], ends[1]);
    graph.linear(both, 0.5 / spread, 0.0)
}
