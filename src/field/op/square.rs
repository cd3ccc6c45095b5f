//! The square.

use super::super::leaf::Quadric;
use super::*;

impl Operation<1> for Square {
    fn value(self, [a]: [f64; 1]) -> f64 {
        a * a
    }

    #[inline(always)]
    fn slopes(self, [a]: [f32; 1]) -> (f32, [f32; 1]) {
        (a * a, [2.0 * a])
    }

    fn bounds(self, [a]: [Interval; 1]) -> Interval {
        if a == Interval::ZERO {
            return a;
        }
        let abs = a.abs();
        let lo = if abs.lo == 0.0 { 0.0 } else { (abs.lo * abs.lo).next_down().max(0.0) };
        Interval::checked(lo, (abs.hi * abs.hi).next_up())
    }

    fn simplified(self, graph: &mut Graph, [a]: [Node; 1]) -> Option<Node> {
        match graph.op(a) {
            Op::Affine(index) => Some(graph.quadric_leaf(Quadric::square(graph.affines[index as usize]))),
            Op::Unary(Unary::Abs | Unary::Linear { scale: -1.0, offset: 0.0 }, value) => {
                Some(graph.unary(Unary::Square, Node(value)))
            }
            _ => None,
        }
    }
}
