//! The absolute value.

use super::*;

impl Operation<1> for Abs {
    const NATURE: Nature = Nature { shortens: true, creases: true, ..Nature::PLAIN };
    const FUNCTIONS: &'static [Function] =
        &[function("abs", 1, "abs(x)", "x without its sign", |graph, a| graph.abs(a[0]))];

    fn value(self, [a]: [f64; 1]) -> f64 {
        a.abs()
    }

    #[inline(always)]
    fn slopes(self, [a]: [f32; 1]) -> (f32, [f32; 1]) {
        (a.abs(), [if a < 0.0 { -1.0 } else { 1.0 }])
    }

    fn bounds(self, [a]: [Interval; 1]) -> Interval {
        a.abs()
    }

    fn facts(self, [a]: [Facts; 1]) -> Facts {
        Facts::steep(a.steepness())
    }

    fn simplified(self, graph: &mut Graph, [a]: [Node; 1]) -> Option<Node> {
        matches!(graph.op(a), Op::Unary(Unary::Abs | Unary::Square | Unary::Sqrt | Unary::Exp, _)).then_some(a)
    }

    fn same(self, [a]: [Interval; 1]) -> Same {
        match a {
            _ if a.lo >= 0.0 => Same::Argument(0),
            _ if a.hi <= 0.0 => Same::Negated(0),
            _ => Same::Itself,
        }
    }
}
