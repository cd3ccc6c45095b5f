//! The cube root, negative where its argument is.

use super::*;

impl Operation<1> for Cbrt {
    const FUNCTIONS: &'static [Function] =
        &[function("cbrt", 1, "cbrt(x)", "the cube root, negative where x is", |graph, a| {
            graph.unary(Unary::Cbrt, a[0])
        })];

    fn value(self, [a]: [f64; 1]) -> f64 {
        libm::cbrt(a)
    }

    #[inline(always)]
    fn slopes(self, [a]: [f32; 1]) -> (f32, [f32; 1]) {
        let root = math::cbrt(a);
        let slope = 1.0 / (3.0 * root * root);
        (root, [if root != 0.0 { slope } else { 0.0 }])
    }

    fn bounds(self, [a]: [Interval; 1]) -> Interval {
        a.rising(libm::cbrt)
    }
}
