//! 1 where two values are equal, else 0.

use super::*;

impl Operation<2> for Equal {
    const NATURE: Nature = Nature { jumps: true, shortens: true, ..Nature::PLAIN };

    fn value(self, [a, b]: [f64; 2]) -> f64 {
        if a.is_nan() || b.is_nan() {
            return f64::NAN;
        }
        if a == b { 1.0 } else { 0.0 }
    }

    #[inline(always)]
    fn slopes(self, [a, b]: [f32; 2]) -> (f32, [f32; 2]) {
        let unknown = if a.is_nan() | b.is_nan() { f32::NAN } else { 0.0 };
        (unknown + if a == b { 1.0 } else { 0.0 }, [0.0; 2])
    }

    fn bounds(self, [a, b]: [Interval; 2]) -> Interval {
        let apart = a.hi < b.lo || b.hi < a.lo;
        let same = a.lo == a.hi && a == b;
        Interval::new(if same { 1.0 } else { 0.0 }, if apart { 0.0 } else { 1.0 })
    }
}
