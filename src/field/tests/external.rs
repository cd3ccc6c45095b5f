//! Fields of other graphs as operands: the same answers as if the expression were one.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::Samples;
use crate::field::{Aabb, BATCH, Expression, Field, Gradients, Graph, Node, SetSystem, rotation};

const WORLD: Aabb = Aabb::new(DVec3::splat(-2.0), DVec3::splat(2.0));

fn part(graph: &mut Graph) -> Node {
    let (ball, block) = (graph.sphere(0.8), graph.cuboid(DVec3::new(1.0, 1.4, 0.6)));
    graph.difference(SetSystem::R0, ball, &[block])
}

/// A solid around a part: placed, mirrored, grown, in a union.
fn around(graph: &mut Graph, part: Node) -> Node {
    let map = DAffine3::from_mat3_translation(rotation(DVec3::new(20.0, 40.0, 60.0)) * 1.3, DVec3::new(0.4, -0.3, 0.2));
    let placed = graph.transform(part, &map).expect("the map is invertible");
    let mirrored = graph.mirror(placed, DVec3::new(1.0, 0.5, 0.0), 0.1);
    let grown = graph.offset(placed, 0.05);
    let other = graph.sphere(0.5);
    let both = graph.union(SetSystem::R0, &[placed, mirrored]);
    let all = graph.union(SetSystem::MinMax, &[both, other]);
    graph.intersection(SetSystem::R0, &[all, grown])
}

fn pair() -> (Expression, Expression) {
    let mut inner = Graph::new();
    let node = part(&mut inner);
    let field: Arc<dyn Field> = Arc::new(Expression::new(&inner, node));
    let mut graph = Graph::new();
    let node = graph.field(field);
    let node = around(&mut graph, node);
    let apart = Expression::new(&graph, node);
    let mut graph = Graph::new();
    let node = part(&mut graph);
    let node = around(&mut graph, node);
    (apart, Expression::new(&graph, node))
}

#[test]
fn an_operand_from_elsewhere_is_as_good_as_ones_own() {
    let (apart, whole) = pair();
    let mut samples = Samples::new(3);
    let (mut first, mut second) = (apart.evaluator(), whole.evaluator());
    let (mut values, mut one, mut other) = ([0.0; BATCH], Gradients::new(), Gradients::new());
    let points = samples.batch(&WORLD, 500);
    first.values(&points, &mut values);
    first.gradients(&points, &mut one);
    second.gradients(&points, &mut other);
    for i in 0..points.len {
        let p = points.position(i);
        assert!((apart.reference(p) - whole.reference(p)).abs() < 1e-12);
        assert!((values[i] - other.value[i]).abs() < 1e-5 && (one.value[i] - other.value[i]).abs() < 1e-5);
        assert!((one.gradient(i) - other.gradient(i)).length() < 1e-3, "{} {}", one.gradient(i), other.gradient(i));
    }
}

#[test]
fn pruning_reaches_into_operands_where_only_signs_matter() {
    let (apart, whole) = pair();
    let mut samples = Samples::new(5);
    let mut evaluator = apart.evaluator();
    let mut values = [0.0; BATCH];
    for _ in 0..300 {
        let min = samples.within(&WORLD);
        let outer = Aabb::new(min, min + 0.4);
        let inner = Aabb::new(min + 0.1, min + 0.2);
        evaluator.enter(&outer);
        evaluator.enter(&inner);
        let bound = evaluator.bounds();
        let points = samples.batch(&inner, 20);
        evaluator.values(&points, &mut values);
        for i in 0..points.len {
            let value = whole.reference(points.position(i));
            assert!((bound.lo <= 0.0 || value > 0.0) && (bound.hi >= 0.0 || value < 0.0));
            assert!(value.abs() < 1e-5 || (values[i] > 0.0) == (value > 0.0), "{} for {value}", values[i]);
        }
        evaluator.leave();
        evaluator.leave();
    }
}

#[test]
fn branches_of_operands_are_branches() {
    let mut inner = Graph::new();
    let node = part(&mut inner);
    let mut graph = Graph::new();
    let node = graph.field(Arc::new(Expression::new(&inner, node)));
    let map = DAffine3::from_mat3_translation(rotation(DVec3::new(0.0, 0.0, 90.0)) * 2.0, DVec3::X);
    let node = graph.transform(node, &map).expect("the map is invertible");
    let field = Expression::new(&graph, node);
    let mut evaluator = field.evaluator();
    // A ball, and a box of six faces.
    assert_eq!(evaluator.branches(), 7);
    let mut points = crate::field::Points::new(DVec3::X);
    points.push(glam::Vec3::new(0.5, 0.0, 0.0));
    let mut out = Gradients::new();
    let mut found = Vec::new();
    for branch in 0..7 {
        evaluator.branch(branch, &points, &mut out);
        assert!((out.gradient(0).length() - 1.0).abs() < 1e-6);
        found.push((out.value[0] * 1000.0).round() / 1000.0);
    }
    found.sort_by(f32::total_cmp);
    // Turned by 90° and doubled: half the box is 1.4 × 1.0 × 0.6, the ball 1.6; box faces count from outside.
    assert_eq!(found, [-1.9, -1.0, -1.0, -0.9, -0.6, -0.6, 1.1]);
}
