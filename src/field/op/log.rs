//! The natural logarithm: −∞ of zero, not a number of less.

use super::*;

impl Operation<1> for Log {
    const FUNCTIONS: &'static [Function] = &[
        function("ln", 1, "ln(x)", "the natural logarithm; of a negative number not a number", |graph, a| {
            graph.unary(Unary::Log, a[0])
        }),
        function("log", 1, "log(x)", "the same as `ln`", |graph, a| graph.unary(Unary::Log, a[0])),
    ];

    fn value(self, [a]: [f64; 1]) -> f64 {
        libm::log(a)
    }

    #[inline(always)]
    fn slopes(self, [a]: [f32; 1]) -> (f32, [f32; 1]) {
        (math::log(a), [1.0 / a])
    }

    /// Everything where it may be undefined.
    fn bounds(self, [a]: [Interval; 1]) -> Interval {
        if a.lo < 0.0 || a.hi <= 0.0 { Interval::ALL } else { a.rising(libm::log) }
    }
}
