//! The difference.

use super::*;

impl Operation<2> for Sub {
    fn value(self, [a, b]: [f64; 2]) -> f64 {
        a - b
    }

    #[inline(always)]
    fn slopes(self, [a, b]: [f32; 2]) -> (f32, [f32; 2]) {
        (a - b, [1.0, -1.0])
    }

    fn bounds(self, [a, b]: [Interval; 2]) -> Interval {
        a + -b
    }

    fn facts(self, arguments: [Facts; 2]) -> Facts {
        Binary::Add.facts(arguments)
    }

    fn simplified(self, graph: &mut Graph, [a, b]: [Node; 2]) -> Option<Node> {
        match (graph.as_constant(a), graph.as_constant(b)) {
            (Some(value), _) => Some(graph.linear(b, -1.0, value)),
            (_, Some(value)) => Some(graph.linear(a, 1.0, -value)),
            _ => graph.sum_of_leaves(a, b, -1.0).or_else(|| (a == b).then(|| graph.constant(0.0))),
        }
    }

    fn same(self, [_, b]: [Interval; 2]) -> Same {
        if b == Interval::ZERO { Same::Argument(0) } else { Same::Itself }
    }
}
