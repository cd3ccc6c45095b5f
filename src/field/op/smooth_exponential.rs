//! The greater value, rounded by exponentials: `w·log₂(2^(a/w) + 2^(b/w))`, as `max(a, b) + w·log₂(1 + 2^(−|a − b|/w))`, which
//! does not overflow.
//!
//! The exponential smooth minimum (Quilez, Smooth minimum), turned around. Of three and more it does not depend on their order.

use super::*;

impl Operation<2> for SmoothExponential {
    fn value(self, [a, b]: [f64; 2]) -> f64 {
        use std::f64::consts::LN_2;
        let greater = a.max(b);
        // Bounds over endless boxes are infinite.
        if greater.is_infinite() {
            return greater;
        }
        let share = libm::exp(-(a - b).abs() * (LN_2 / self.width));
        greater + self.width / LN_2 * libm::log(1.0 + share)
    }

    #[inline(always)]
    fn slopes(self, [a, b]: [f32; 2]) -> (f32, [f32; 2]) {
        use std::f64::consts::LN_2;
        let (apart, greater) = ((a - b).abs(), if a > b { a } else { b });
        let share = math::exp(-apart * (LN_2 / self.width) as f32);
        let lesser = share / (1.0 + share);
        let by_a = if a > b { 1.0 - lesser } else { lesser };
        (greater + (self.width / LN_2) as f32 * math::log(1.0 + share), [by_a, 1.0 - by_a])
    }

    /// By monotony.
    fn bounds(self, [a, b]: [Interval; 2]) -> Interval {
        Interval::widened(self.value([a.lo, b.lo]), self.value([a.hi, b.hi]))
    }

    fn facts(self, [a, b]: [Facts; 2]) -> Facts {
        rounded(a, b, self.width)
    }
}
