//! The intersection of system R₀, `a + b − √(a² + b²)`, by the union of complements.

use super::*;

impl Operation<2> for Intersection {
    const NATURE: Nature = Nature::INTERSECTION;

    fn value(self, [a, b]: [f64; 2]) -> f64 {
        -Binary::Union.value([-a, -b])
    }

    #[inline(always)]
    fn slopes(self, [a, b]: [f32; 2]) -> (f32, [f32; 2]) {
        let (value, by) = Union {}.slopes([-a, -b]);
        (-value, by)
    }

    /// By monotony.
    fn bounds(self, [a, b]: [Interval; 2]) -> Interval {
        Interval::widened(self.value([a.lo, b.lo]), self.value([a.hi, b.hi]))
    }

    fn facts(self, [a, b]: [Facts; 2]) -> Facts {
        Facts::intersection(a, b, Binary::Union.facts([a, b]).slope)
    }
}
