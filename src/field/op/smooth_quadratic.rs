//! The greater value, rounded where two differ by less than a width: `max(a, b) + h²·w/4`, h = 1 − |a − b|/w.
//!
//! The polynomial smooth minimum of second degree (Quilez, Smooth minimum), turned around. Its slope is a mean of the slopes of
//! both with weights that are not negative.

use super::*;

impl Operation<2> for SmoothQuadratic {
    const NATURE: Nature = Nature { shortens: true, ..Nature::PLAIN };

    fn value(self, [a, b]: [f64; 2]) -> f64 {
        let near = (1.0 - (a - b).abs() / self.width).max(0.0);
        a.max(b) + near * near * (self.width / 4.0)
    }

    #[inline(always)]
    fn slopes(self, [a, b]: [f32; 2]) -> (f32, [f32; 2]) {
        let width = self.width as f32;
        let (apart, greater) = ((a - b).abs(), if a > b { a } else { b });
        let near = 1.0 - apart / width;
        let near = if near > 0.0 { near } else { 0.0 };
        let lesser = near / 2.0;
        let by_a = if a > b { 1.0 - lesser } else { lesser };
        (greater + near * near * (width / 4.0), [by_a, 1.0 - by_a])
    }

    /// By monotony.
    fn bounds(self, [a, b]: [Interval; 2]) -> Interval {
        Interval::widened(self.value([a.lo, b.lo]), self.value([a.hi, b.hi]))
    }

    fn facts(self, [a, b]: [Facts; 2]) -> Facts {
        rounded(a, b, self.width / 4.0)
    }

    fn same(self, arguments: [Interval; 2]) -> Same {
        far_apart(arguments, self.width)
    }
}
