//! Linear blending and the plain union, as fields in world units: what space-time blending is compared with.

use std::sync::Arc;

use crate::distance::Distance;
use crate::field::{Aabb, Expression, Field, Graph, SetSystem};

/// (1 − t)·f₁ + t·f₂ of two distances, for t in (0, 1).
pub(super) fn linear(first: Arc<dyn Distance>, second: Arc<dyn Distance>, t: f64) -> Arc<dyn Field> {
    // Where both are negative so is the sum.
    let around = both_boxes(first.bounding_box(), second.bounding_box());
    let mut graph = Graph::new();
    let (one, two) = (graph.field(first), graph.field(second));
    let (one, two) = (graph.linear(one, 1.0 - t, 0.0), graph.linear(two, t, 0.0));
    let sum = graph.add(one, two);
    expression(&graph, sum, around)
}

/// max(f₁, f₂): both objects as they are, edges included.
pub(super) fn union(first: Arc<dyn Field>, second: Arc<dyn Field>) -> Arc<dyn Field> {
    let around = both_boxes(first.bounding_box(), second.bounding_box());
    let mut graph = Graph::new();
    let solids = [graph.field(first), graph.field(second)];
    let joined = graph.union(SetSystem::MinMax, &solids);
    expression(&graph, joined, around)
}

fn both_boxes(first: Option<Aabb>, second: Option<Aabb>) -> Option<Aabb> {
    Some(first?.union(second?))
}

fn expression(graph: &Graph, node: crate::field::Node, around: Option<Aabb>) -> Arc<dyn Field> {
    let field = Expression::new(graph, node);
    match around {
        Some(around) => Arc::new(field.known_within(around)),
        None => Arc::new(field),
    }
}
