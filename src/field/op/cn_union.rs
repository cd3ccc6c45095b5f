//! The union of Rvachev's normalised system of class Cⁿ⁻¹, by the intersection of complements.

use super::*;

impl Operation<2> for CnUnion {
    const NATURE: Nature = Nature::UNION;

    fn value(self, [a, b]: [f64; 2]) -> f64 {
        -Binary::CnIntersection { order: self.order }.value([-a, -b])
    }

    #[inline(always)]
    fn slopes(self, [a, b]: [f32; 2]) -> (f32, [f32; 2]) {
        let (value, by) = CnIntersection { order: self.order }.slopes([-a, -b]);
        (-value, by)
    }

    /// By monotony.
    fn bounds(self, [a, b]: [Interval; 2]) -> Interval {
        cn_intersection::widened_power(self.value([a.lo, b.lo]), self.value([a.hi, b.hi]))
    }

    /// Outside of both F is greatest where they are equal: 2^(−1/n) of them is left.
    fn facts(self, [a, b]: [Facts; 2]) -> Facts {
        Facts::union(a, b, cn_intersection::steep(a, b), libm::exp2(-1.0 / f64::from(self.order)))
    }

    /// Where one is not negative and the other not positive, it is the former.
    fn same(self, [a, b]: [Interval; 2]) -> Same {
        match (a, b) {
            _ if a.lo >= 0.0 && b.hi <= 0.0 => Same::Argument(0),
            _ if b.lo >= 0.0 && a.hi <= 0.0 => Same::Argument(1),
            _ => Same::Itself,
        }
    }

    #[inline(always)]
    fn visit(self, visitor: impl Visitor<2>) {
        match self.order {
            2 => visitor.visit(Self { order: 2 }),
            3 => visitor.visit(Self { order: 3 }),
            4 => visitor.visit(Self { order: 4 }),
            _ => visitor.visit(self),
        }
    }
}
