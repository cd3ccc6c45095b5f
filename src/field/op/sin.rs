//! The sine.

use super::*;

impl Operation<1> for Sin {
    const FUNCTIONS: &'static [Function] =
        &[function("sin", 1, "sin(x)", "the sine of an angle in radians", |graph, a| graph.unary(Unary::Sin, a[0]))];

    fn value(self, [a]: [f64; 1]) -> f64 {
        libm::sin(a)
    }

    #[inline(always)]
    fn slopes(self, [a]: [f32; 1]) -> (f32, [f32; 1]) {
        (math::sin(a), [math::cos(a)])
    }

    fn bounds(self, [a]: [Interval; 1]) -> Interval {
        use std::f64::consts::{FRAC_PI_2, TAU};
        if a.hi - a.lo >= TAU || a.lo.abs().max(a.hi.abs()) > 1e5 {
            return Interval::new(-1.0, 1.0);
        }
        // Whether a point phase + k·2π lies in the interval; a near miss counts, so that rounding cannot hide one.
        let meets = |phase: f64| {
            let next = phase + ((a.lo - phase) / TAU - 1e-9).ceil() * TAU;
            next <= a.hi + 1e-8
        };
        let ends = (libm::sin(a.lo), libm::sin(a.hi));
        let lo = if meets(-FRAC_PI_2) { -1.0 } else { ends.0.min(ends.1) };
        let hi = if meets(FRAC_PI_2) { 1.0 } else { ends.0.max(ends.1) };
        let both = Interval::widened(lo, hi);
        Interval::new(both.lo.max(-1.0), both.hi.min(1.0))
    }

    fn facts(self, [a]: [Facts; 1]) -> Facts {
        Facts::steep(a.steepness())
    }
}
