//! The greater value, joined by a piece of a circle where two differ by less than a width:
//! `max(a, b) + w/2·(1 + h − √(1 − h·(h − 2)))`, h = 1 − |a − b|/w.
//!
//! The circular smooth minimum (Quilez, Smooth minimum), turned around.

use super::*;

impl Operation<2> for SmoothCircular {
    const NATURE: Nature = Nature { shortens: true, ..Nature::PLAIN };

    fn value(self, [a, b]: [f64; 2]) -> f64 {
        let near = (1.0 - (a - b).abs() / self.width).max(0.0);
        a.max(b) + self.width / 2.0 * (1.0 + near - (1.0 - near * (near - 2.0)).sqrt())
    }

    #[inline(always)]
    fn slopes(self, [a, b]: [f32; 2]) -> (f32, [f32; 2]) {
        let width = self.width as f32;
        let (apart, greater) = ((a - b).abs(), if a > b { a } else { b });
        let near = 1.0 - apart / width;
        let near = if near > 0.0 { near } else { 0.0 };
        let root = (1.0 - near * (near - 2.0)).sqrt();
        let lesser = 0.5 * (1.0 - (1.0 - near) / root);
        let by_a = if a > b { 1.0 - lesser } else { lesser };
        (greater + width / 2.0 * (1.0 + near - root), [by_a, 1.0 - by_a])
    }

    /// By monotony.
    fn bounds(self, [a, b]: [Interval; 2]) -> Interval {
        Interval::widened(self.value([a.lo, b.lo]), self.value([a.hi, b.hi]))
    }

    fn facts(self, [a, b]: [Facts; 2]) -> Facts {
        rounded(a, b, self.width * (1.0 - std::f64::consts::FRAC_1_SQRT_2))
    }

    fn same(self, arguments: [Interval; 2]) -> Same {
        far_apart(arguments, self.width)
    }
}
