//! The product.

use super::*;

impl Operation<2> for Mul {
    fn value(self, [a, b]: [f64; 2]) -> f64 {
        a * b
    }

    #[inline(always)]
    fn slopes(self, [a, b]: [f32; 2]) -> (f32, [f32; 2]) {
        (a * b, [b, a])
    }

    fn bounds(self, [a, b]: [Interval; 2]) -> Interval {
        a * b
    }

    fn simplified(self, graph: &mut Graph, [a, b]: [Node; 2]) -> Option<Node> {
        match (graph.as_constant(a), graph.as_constant(b)) {
            (Some(value), _) => Some(graph.linear(b, value, 0.0)),
            (_, Some(value)) => Some(graph.linear(a, value, 0.0)),
            _ => (a == b).then(|| graph.square(a)),
        }
    }
}
