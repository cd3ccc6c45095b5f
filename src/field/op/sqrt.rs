//! The square root; not a number of what is negative.

use super::super::leaf::Quadric;
use super::*;

impl Operation<1> for Sqrt {
    const FUNCTIONS: &'static [Function] =
        &[function("sqrt", 1, "sqrt(x)", "the square root; of a negative number not a number", |graph, a| {
            graph.sqrt(a[0])
        })];

    fn value(self, [a]: [f64; 1]) -> f64 {
        a.sqrt()
    }

    #[inline(always)]
    fn slopes(self, [a]: [f32; 1]) -> (f32, [f32; 1]) {
        let root = a.sqrt();
        let slope = 0.5 / root;
        (root, [if root > 0.0 { slope } else { 0.0 }])
    }

    fn bounds(self, [a]: [Interval; 1]) -> Interval {
        if a.lo < 0.0 {
            return Interval::ALL;
        }
        let lo = if a.lo == 0.0 { 0.0 } else { a.lo.sqrt().next_down() };
        Interval::checked(lo, if a.hi == 0.0 { 0.0 } else { a.hi.sqrt().next_up() })
    }

    fn simplified(self, graph: &mut Graph, [a]: [Node; 1]) -> Option<Node> {
        match graph.op(a) {
            Op::Unary(Unary::Square, value) => Some(graph.abs(Node(value))),
            Op::Quadric(index) => root_of_quadric(graph, graph.quadrics[index as usize]),
            _ => None,
        }
    }
}

/// √ of a sum of squares, which has a known slope; of a single square, the absolute value.
fn root_of_quadric(graph: &mut Graph, quadric: Quadric) -> Option<Node> {
    let slope = quadric.root_slope()?;
    if quadric.terms[1].0 == 0.0 {
        let (weight, form) = quadric.terms[0];
        let form = graph.affine_leaf(form.linear(weight.sqrt(), 0.0));
        return Some(graph.abs(form));
    }
    let radicand = graph.quadric_leaf(quadric);
    Some(graph.intern(Op::Unary(Unary::Sqrt, radicand.0), Facts::new(None, Slope::Lipschitz(slope))))
}
