//! The quotient.

use super::*;

impl Operation<2> for Div {
    fn value(self, [a, b]: [f64; 2]) -> f64 {
        a / b
    }

    #[inline(always)]
    fn slopes(self, [a, b]: [f32; 2]) -> (f32, [f32; 2]) {
        let inverse = 1.0 / b;
        let value = a / b;
        (value, [inverse, -(value * inverse)])
    }

    fn bounds(self, [a, b]: [Interval; 2]) -> Interval {
        a * Unary::Recip.bounds([b])
    }

    fn simplified(self, graph: &mut Graph, [a, b]: [Node; 2]) -> Option<Node> {
        match (graph.as_constant(a), graph.as_constant(b)) {
            (_, Some(value)) if value != 0.0 => Some(graph.linear(a, 1.0 / value, 0.0)),
            (Some(value), _) => {
                let inverse = graph.unary(Unary::Recip, b);
                Some(graph.linear(inverse, value, 0.0))
            }
            _ => None,
        }
    }
}
