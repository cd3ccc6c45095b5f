//! Surfaces that a scalar moves along their normal, and solids filled by two structures that a scalar mixes.
//!
//! Where f is a solid's signed distance and d the scalar, the moved solid is F = f + d (STTI, "scalar displacement").

use std::sync::Arc;

use crate::attribute::{Scalar, ScalarField};
use crate::field::{Aabb, Expression, Field, Graph, Interval, Node, Side, Slope};

use crate::node::measured::SLACK;
use crate::text::problem::Problem;
use crate::text::source::Span;

/// How often the greatest displacement is sought in a box grown by the one found before.
const TRIES: usize = 16;
/// The part of a solid's longest side that a scalar's gradient is taken over. Greater rounds its detail; smaller lets
/// the rounding of `f32` show.
const GRADIENT_STEP: f64 = 1.0 / 8192.0;

/// A scalar that moves the surface of a solid.
pub(crate) struct Displacement {
    scalar: Arc<Scalar>,
    /// The box of the solid as it is.
    solid: Aabb,
    /// What the scalar may be wherever the moved surface may be.
    range: Interval,
}

impl Displacement {
    /// How a scalar moves the surface of the solid in a box; `None` where the scalar has no greatest value there, or one
    /// that grows as fast as the surface is moved.
    pub fn new(scalar: Arc<Scalar>, solid: Aabb) -> Option<Self> {
        let mut sampler = scalar.sampler();
        let mut reach = 0.0;
        for _ in 0..TRIES {
            let [range] = sampler.bounds(&solid.grown(SLACK * reach));
            if !range.hi.is_finite() {
                return None;
            }
            if range.hi <= reach {
                drop(sampler);
                return Some(Self { scalar, solid, range });
            }
            // A little more at once where it has grown with the box.
            reach = if reach == 0.0 { range.hi } else { 1.25 * range.hi };
        }
        None
    }

    /// The greatest way outward, units.
    pub fn reach(&self) -> f64 {
        self.range.hi.max(0.0)
    }

    /// Whether a field of this slope is the distance on all sides that the surface is moved to.
    pub fn is_distance(&self, slope: Slope) -> bool {
        (self.range.hi <= 0.0 || slope.is_exact(Side::Outside))
            && (self.range.lo >= 0.0 || slope.is_exact(Side::Inside))
    }

    /// The distances, positive inside, between the surface and where it may be moved to.
    pub fn levels(&self) -> Interval {
        Interval::new((-self.range.hi).min(0.0), (-self.range.lo).max(0.0))
    }

    /// The moved solid, from its distance.
    pub fn apply(&self, graph: &mut Graph, distance: Node) -> Node {
        let most = self.reach();
        let around = self.solid.grown(SLACK * most);
        let step = GRADIENT_STEP * self.solid.size().max_element();
        // The bound holds where the surface may be; what lies beyond is no part of the solid.
        let way = graph.field(Arc::new(ScalarField { scalar: Arc::clone(&self.scalar), most, step }));
        graph.displaced(distance, way, self.range.hi <= 0.0, around)
    }

    /// The moved solid, from a distance that is a field of its own.
    pub fn of_field(&self, distance: Arc<dyn Field>) -> Arc<dyn Field> {
        let mut graph = Graph::new();
        let distance = graph.field(distance);
        let moved = self.apply(&mut graph, distance);
        Arc::new(Expression::new(&graph, moved))
    }
}

/// The problem of a scalar without a greatest value.
pub(crate) fn no_greatest(span: Span, name: &str, shape: &str) -> Problem {
    Problem::new(span, format!("`{name}` has no greatest value near `{shape}`, whose surface it moves"))
        .help("hold it to one: \"min(…, 0.1)\"")
}

/// `solid` where (1 − ω)·a + ω·b is not negative (STTI, section 6.5). `size` is about how large the solid is.
pub(crate) fn filled(graph: &mut Graph, solid: Node, structures: [Node; 2], omega: Arc<Scalar>, size: f64) -> Node {
    let mixed = structures_mixed(graph, structures, mixing(omega, size));
    graph.min(solid, mixed)
}

/// A scalar that mixes structures in a solid, as a field.
pub(crate) fn mixing(omega: Arc<Scalar>, size: f64) -> Arc<dyn Field> {
    Arc::new(ScalarField { scalar: omega, most: f64::INFINITY, step: GRADIENT_STEP * size })
}

/// (1 − ω)·a + ω·b.
pub(crate) fn structures_mixed(graph: &mut Graph, [a, b]: [Node; 2], omega: Arc<dyn Field>) -> Node {
    let omega = graph.field(omega);
    let change = graph.sub(b, a);
    let added = graph.mul(omega, change);
    graph.add(a, added)
}
