//! The greater value: the union that keeps exact distances exact on one side.

use super::super::facts::exact;
use super::*;

impl Operation<2> for Max {
    const NATURE: Nature = Nature { creases: true, ..Nature::UNION };
    const FUNCTIONS: &'static [Function] =
        &[any_number("max", "max(x, y, …)", "the greatest of one number or more", |graph, a| {
            fold(graph, Binary::Max, a)
        })];

    fn value(self, [a, b]: [f64; 2]) -> f64 {
        a.max(b)
    }

    #[inline(always)]
    fn slopes(self, [a, b]: [f32; 2]) -> (f32, [f32; 2]) {
        let first = if a > b { 1.0 } else { 0.0 };
        (if a > b { a } else { b }, [first, 1.0 - first])
    }

    fn bounds(self, [a, b]: [Interval; 2]) -> Interval {
        Interval::new(a.lo.max(b.lo), a.hi.max(b.hi))
    }

    fn facts(self, [a, b]: [Facts; 2]) -> Facts {
        let slope = match (a.slope, b.slope) {
            (Slope::Exact { outside, .. }, Slope::Exact { outside: o, .. }) => exact(outside && o, false),
            _ => Facts::steep(a.steepness().zip(b.steepness()).map(|(a, b)| a.max(b))).slope,
        };
        Facts::union(a, b, slope, 1.0)
    }

    fn simplified(self, _: &mut Graph, [a, b]: [Node; 2]) -> Option<Node> {
        (a == b).then_some(a)
    }

    fn same(self, [a, b]: [Interval; 2]) -> Same {
        match (a, b) {
            _ if b.hi <= a.lo => Same::Argument(0),
            _ if a.hi <= b.lo => Same::Argument(1),
            _ => Same::Itself,
        }
    }
}
