//! The greatest whole number that is not above a value.

use super::*;

impl Operation<1> for Floor {
    const NATURE: Nature = Nature { jumps: true, shortens: true, ..Nature::PLAIN };
    const FUNCTIONS: &'static [Function] =
        &[function("floor", 1, "floor(x)", "the greatest whole number that is not above x; jumps", |graph, a| {
            graph.unary(Unary::Floor, a[0])
        })];

    fn value(self, [a]: [f64; 1]) -> f64 {
        a.floor()
    }

    #[inline(always)]
    fn slopes(self, [a]: [f32; 1]) -> (f32, [f32; 1]) {
        (a.floor(), [0.0])
    }

    fn bounds(self, [a]: [Interval; 1]) -> Interval {
        Interval::new(a.lo.floor(), a.hi.floor())
    }
}
