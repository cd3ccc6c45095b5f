//! The exact intersection of two exact distances whose surfaces meet at right angles.

use super::*;

impl Operation<2> for Corner {
    const NATURE: Nature = Nature::INTERSECTION;

    fn value(self, [a, b]: [f64; 2]) -> f64 {
        if a.min(b) >= 0.0 {
            return a.min(b);
        }
        let (a, b) = (a.min(0.0), b.min(0.0));
        -(a * a + b * b).sqrt()
    }

    #[inline(always)]
    fn slopes(self, [a, b]: [f32; 2]) -> (f32, [f32; 2]) {
        let (lesser, greater) = if a < b { (a, b) } else { (b, a) };
        let greater = if greater < 0.0 { greater } else { 0.0 };
        let outside = -(lesser * lesser + greater * greater).sqrt();
        let value = if lesser >= 0.0 { lesser } else { outside };
        let (first, second) = (if a < 0.0 { -a } else { 0.0 }, if b < 0.0 { -b } else { 0.0 });
        let inverse = 1.0 / (first * first + second * second).sqrt();
        let nearer = if a < b { 1.0 } else { 0.0 };
        let outside = (first > 0.0 || second > 0.0) && inverse < f32::INFINITY;
        let by_a = if outside { first * inverse } else { nearer };
        (value, [by_a, if outside { second * inverse } else { 1.0 - nearer }])
    }

    /// By monotony.
    fn bounds(self, [a, b]: [Interval; 2]) -> Interval {
        Interval::widened(self.value([a.lo, b.lo]), self.value([a.hi, b.hi]))
    }

    fn facts(self, [a, b]: [Facts; 2]) -> Facts {
        let steep = Facts::steep(a.steepness().zip(b.steepness()).map(|(a, b)| a.hypot(b)));
        Facts::intersection(a, b, steep.slope)
    }

    /// Beside an argument that is inside throughout, the other one's value is the distance.
    fn same(self, [a, b]: [Interval; 2]) -> Same {
        match (a, b) {
            _ if b.lo >= 0.0 && a.hi <= b.lo => Same::Argument(0),
            _ if a.lo >= 0.0 && b.hi <= a.lo => Same::Argument(1),
            _ => Same::Itself,
        }
    }
}
