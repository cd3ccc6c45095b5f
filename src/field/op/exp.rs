//! The exponential.

use super::*;

impl Operation<1> for Exp {
    const FUNCTIONS: &'static [Function] =
        &[function("exp", 1, "exp(x)", "e to the power of x", |graph, a| graph.unary(Unary::Exp, a[0]))];

    fn value(self, [a]: [f64; 1]) -> f64 {
        libm::exp(a)
    }

    #[inline(always)]
    fn slopes(self, [a]: [f32; 1]) -> (f32, [f32; 1]) {
        let value = math::exp(a);
        (value, [value])
    }

    fn bounds(self, [a]: [Interval; 1]) -> Interval {
        let bounds = a.rising(libm::exp);
        Interval::new(bounds.lo.max(0.0), bounds.hi)
    }
}
