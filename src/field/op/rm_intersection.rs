//! The intersection of system R_m, `(a + b − √(a² + b²))·(a² + b²)^(m/2)`, by the union of complements.

use super::*;

impl Operation<2> for RmIntersection {
    const NATURE: Nature = Nature::INTERSECTION;

    fn value(self, [a, b]: [f64; 2]) -> f64 {
        -Binary::RmUnion { order: self.order }.value([-a, -b])
    }

    #[inline(always)]
    fn slopes(self, [a, b]: [f32; 2]) -> (f32, [f32; 2]) {
        let (value, by) = RmUnion { order: self.order }.slopes([-a, -b]);
        (-value, by)
    }

    fn bounds(self, [a, b]: [Interval; 2]) -> Interval {
        -Binary::RmUnion { order: self.order }.bounds([-a, -b])
    }

    fn facts(self, [a, b]: [Facts; 2]) -> Facts {
        Facts { fall: 0.0, ..Facts::intersection(a, b, Slope::Unknown) }
    }

    #[inline(always)]
    fn visit(self, visitor: impl Visitor<2>) {
        rm_union::with_order(self.order, |order| visitor.visit(Self { order }));
    }
}
