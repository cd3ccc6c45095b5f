//! A power with a whole exponent of at least 3, by repeated squaring.

use super::*;

impl Operation<1> for Powi {
    fn value(self, [a]: [f64; 1]) -> f64 {
        let (mut result, mut square, mut rest) = (1.0, a, self.exponent);
        while rest > 0 {
            if rest & 1 == 1 {
                result *= square;
            }
            square *= square;
            rest >>= 1;
        }
        result
    }

    #[inline(always)]
    fn slopes(self, [a]: [f32; 1]) -> (f32, [f32; 1]) {
        let below = power(a, self.exponent - 1);
        (power(a, self.exponent), [self.exponent as f32 * below])
    }

    fn bounds(self, [a]: [Interval; 1]) -> Interval {
        let end = |value: f64| self.value([value]);
        let slack = |value: f64| value.abs() * f64::EPSILON * f64::from(self.exponent) + f64::MIN_POSITIVE;
        if self.exponent.is_multiple_of(2) {
            let abs = a.abs();
            let (lo, hi) = (end(abs.lo), end(abs.hi));
            return Interval::checked((lo - slack(lo)).max(0.0), hi + slack(hi));
        }
        let (lo, hi) = (end(a.lo), end(a.hi));
        Interval::checked(lo - slack(lo), hi + slack(hi))
    }

    /// With the exponent known, the loop over its bits is gone and lanes become vectors.
    #[inline(always)]
    fn visit(self, visitor: impl Visitor<1>) {
        match self.exponent {
            3 => visitor.visit(Self { exponent: 3 }),
            4 => visitor.visit(Self { exponent: 4 }),
            5 => visitor.visit(Self { exponent: 5 }),
            6 => visitor.visit(Self { exponent: 6 }),
            8 => visitor.visit(Self { exponent: 8 }),
            _ => visitor.visit(self),
        }
    }
}

/// A value to the power of a whole exponent.
#[inline(always)]
pub(super) fn power(value: f32, exponent: u32) -> f32 {
    let (mut result, mut square, mut rest) = (1.0, value, exponent);
    while rest > 0 {
        if rest & 1 == 1 {
            result *= square;
        }
        square *= square;
        rest >>= 1;
    }
    result
}
