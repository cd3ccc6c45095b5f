//! The cosine.

use super::*;

impl Operation<1> for Cos {
    const FUNCTIONS: &'static [Function] =
        &[function("cos", 1, "cos(x)", "the cosine of an angle in radians", |graph, a| graph.unary(Unary::Cos, a[0]))];

    fn value(self, [a]: [f64; 1]) -> f64 {
        libm::cos(a)
    }

    #[inline(always)]
    fn slopes(self, [a]: [f32; 1]) -> (f32, [f32; 1]) {
        (math::cos(a), [-math::sin(a)])
    }

    fn bounds(self, [a]: [Interval; 1]) -> Interval {
        use std::f64::consts::FRAC_PI_2;
        Unary::Sin.bounds([a + Interval::widened(FRAC_PI_2, FRAC_PI_2)])
    }

    fn facts(self, [a]: [Facts; 1]) -> Facts {
        Facts::steep(a.steepness())
    }
}
