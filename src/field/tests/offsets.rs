//! Offsets of boxes, balls and cylinders: distances on both sides, as those of the solids that they are.

use glam::{DVec2, DVec3};

use super::Samples;
use crate::field::{Aabb, Expression, Field, Graph, Node, Side};

/// The distance to a box with round edges, positive inside.
fn of_box(half: DVec3, round: f64, p: DVec3) -> f64 {
    let past = p.abs() - half;
    round - past.max(DVec3::ZERO).length() - past.max_element().min(0.0)
}

fn of_cylinder(radius: f64, half: f64, round: f64, p: DVec3) -> f64 {
    let past = DVec2::new(p.truncate().length() - radius, p.z.abs() - half);
    round - past.max(DVec2::ZERO).length() - past.max_element().min(0.0)
}

fn holds(graph: &Graph, node: Node, wanted: impl Fn(DVec3) -> f64) {
    assert!([Side::Outside, Side::Inside].into_iter().all(|side| graph.slope(node).is_exact(side)));
    let field = Expression::new(graph, node);
    let (bounds, mut samples) = (field.bounding_box().expect("a box"), Samples::new(7));
    let around = Aabb::new(DVec3::splat(-2.0), DVec3::splat(2.0));
    for _ in 0..2000 {
        let at = samples.within(&around);
        assert!((field.reference(at) - wanted(at)).abs() < 1e-12, "{at}");
        assert!(wanted(at) < 0.0 || bounds.contains(at), "{at}");
    }
}

#[test]
fn what_boxes_and_cylinders_are_grown_and_shrunk_to_is_exact() {
    let mut graph = Graph::new();
    let (cuboid, cylinder) = (graph.cuboid(DVec3::new(1.6, 1.2, 1.0)), graph.cylinder(0.6, 1.4));
    let (ball, less) = (graph.sphere(0.8), graph.offset(cuboid, -0.2));
    let (half, core) = (DVec3::new(0.8, 0.6, 0.5), DVec3::new(0.6, 0.4, 0.3));
    holds(&graph, less, |p| of_box(core, 0.0, p));
    let round = graph.offset(less, 0.2);
    holds(&graph, round, |p| of_box(core, 0.2, p));
    let more = graph.offset(cuboid, 0.3);
    holds(&graph, more, |p| of_box(half, 0.3, p));
    let (less, more) = (graph.offset(cylinder, -0.25), graph.offset(cylinder, 0.25));
    holds(&graph, less, |p| of_cylinder(0.35, 0.45, 0.0, p));
    holds(&graph, more, |p| of_cylinder(0.6, 0.7, 0.25, p));
    let less = graph.offset(ball, -0.3);
    holds(&graph, less, |p| 0.5 - p.length());
}

#[test]
fn what_nothing_is_left_of_is_no_distance() {
    let mut graph = Graph::new();
    let cuboid = graph.cuboid(DVec3::new(1.6, 1.2, 1.0));
    let none = graph.offset(cuboid, -0.5);
    assert!(!graph.slope(none).is_exact(Side::Outside));
}
