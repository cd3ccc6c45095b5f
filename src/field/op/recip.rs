//! One over a value.

use super::*;

impl Operation<1> for Recip {
    fn value(self, [a]: [f64; 1]) -> f64 {
        1.0 / a
    }

    #[inline(always)]
    fn slopes(self, [a]: [f32; 1]) -> (f32, [f32; 1]) {
        let inverse = 1.0 / a;
        (inverse, [-(inverse * inverse)])
    }

    /// Everything where zero is possible.
    fn bounds(self, [a]: [Interval; 1]) -> Interval {
        if a.contains(0.0) { Interval::ALL } else { Interval::outward(1.0 / a.hi, 1.0 / a.lo) }
    }
}
