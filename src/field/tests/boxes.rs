//! Boxes around solids that construction alone does not tell.

use std::sync::Arc;

use glam::DVec3;

use super::Samples;
use crate::field::{Aabb, Blend, Expression, Field, Graph, Node, SetSystem};

const BLEND: Blend = Blend { amount: 0.25, reach: [0.25; 2], bounds: None };

/// Holds that the solid is in its box, and that the box is no more than `slack` larger than what is inside.
fn assert_fits(what: &str, graph: &Graph, node: Node, slack: f64) {
    let field = Expression::new(graph, node);
    let found = field.bounding_box().unwrap_or_else(|| panic!("{what} has a box"));
    let mut samples = Samples::new(7);
    let mut inside = Aabb::new(DVec3::INFINITY, DVec3::NEG_INFINITY);
    let wide = found.grown(0.5 * found.size().max_element());
    for _ in 0..200_000 {
        let p = samples.within(&wide);
        if field.reference(p) >= 0.0 {
            inside = Aabb::new(inside.min.min(p), inside.max.max(p));
        }
    }
    assert!(found.contains(inside.min) && found.contains(inside.max), "{what}: {inside:?} in {found:?}");
    let gap = (inside.min - found.min).max_element().max((found.max - inside.max).max_element());
    assert!(gap <= slack, "{what}: {inside:?} in {found:?}");
}

#[test]
fn unbounded_blends_of_bounded_solids_have_boxes() {
    let mut graph = Graph::new();
    let (ball, ring) = (graph.sphere(0.8), graph.torus(1.0, 0.2));
    let distances = graph.blend_union(ball, ring, &BLEND);
    assert_fits("a blend of distances", &graph, distances, 0.2);
    // No distance, so that only bounds over endless boxes tell where it ends.
    let egg = graph.ellipsoid(DVec3::new(0.5, 0.8, 1.2));
    let others = graph.blend_union(ball, egg, &BLEND);
    assert_fits("a blend with an ellipsoid", &graph, others, 0.4);
    let three = graph.blend_union(distances, egg, &BLEND);
    assert_fits("a blend of a blend", &graph, three, 0.4);
}

#[test]
fn a_blend_of_distances_from_elsewhere_has_a_box() {
    let mut inner = Graph::new();
    let ball = inner.sphere(0.8);
    let ball: Arc<dyn Field> = Arc::new(Expression::new(&inner, ball));
    let mut graph = Graph::new();
    let (one, other) = (graph.field(ball), graph.sphere(0.3));
    let blend = graph.blend_union(one, other, &BLEND);
    // Nothing draws it in: 0.25 / (2 − √2) around, of which some 0.05 are needed.
    assert_fits("a blend of distances from elsewhere", &graph, blend, 0.45);
}

/// What comes from elsewhere is asked for no bounds: construction alone tells.
#[test]
fn blends_of_blends_and_offsets_of_unions_have_boxes() {
    let ball = |radius: f64| {
        let mut inner = Graph::new();
        let ball = inner.sphere(radius);
        Arc::new(Expression::new(&inner, ball)) as Arc<dyn Field>
    };
    let mut graph = Graph::new();
    let [one, two, three] = [0.8, 0.5, 0.3].map(|radius| graph.field(ball(radius)));
    let two = graph.translate(two, DVec3::new(0.9, 0.2, 0.0)).expect("it moves");
    let pair = graph.blend_union(one, two, &BLEND);
    let turned = graph.rotate(pair, DVec3::new(0.0, 30.0, 45.0)).expect("it turns");
    let three = graph.translate(three, DVec3::new(0.0, 1.0, 0.0)).expect("it moves");
    let all = graph.blend_union(turned, three, &BLEND);
    assert_fits("a blend of a turned blend", &graph, all, 2.5);
    let union = graph.union(SetSystem::R0, &[one, two]);
    let grown = graph.offset(union, 0.1);
    assert_fits("an offset R₀ union", &graph, grown, 0.3);
    let stretched = graph.scale(union, DVec3::new(1.0, 2.0, 1.0)).expect("it is scaled");
    let grown = graph.offset(stretched, 0.1);
    assert_fits("an offset of what is stretched", &graph, grown, 1.0);
}
