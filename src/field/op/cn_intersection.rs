//! The intersection of Rvachev's normalised system of class Cⁿ⁻¹: its gradient is 1 on the surface wherever an operand's is.
//!
//! Rvachev, Theory of R-functions, 1982; HFRep, eq. 18, whose two labels are swapped. Between operands that are both positive
//! it is `a·b·(aⁿ + bⁿ)^(−1/n)`; where both are negative, `−(|a|ⁿ + |b|ⁿ)^(1/n)`; otherwise the negative one.

use super::*;

impl Operation<2> for CnIntersection {
    const NATURE: Nature = Nature::INTERSECTION;

    fn value(self, [a, b]: [f64; 2]) -> f64 {
        let (lesser, greater) = (a.min(b), a.max(b));
        if lesser == 0.0 || (lesser < 0.0 && greater >= 0.0) || greater.is_infinite() && lesser > 0.0 {
            return lesser;
        }
        // By the ratio of the two, which does not overflow.
        let grown = |ratio: f64| {
            let sum = 1.0 + libm::pow(ratio, f64::from(self.order));
            if self.order == 2 { sum.sqrt() } else { libm::pow(sum, 1.0 / f64::from(self.order)) }
        };
        if lesser > 0.0 { lesser / grown(lesser / greater) } else { lesser * grown(greater / lesser) }
    }

    /// With r the lesser over the greater, by absolute values, and s = 1 + rⁿ: of positive ones the lesser counts with
    /// s^(−1−1/n), of negative ones the farther from zero with s^(1/n−1); the other with as much times rⁿ⁺¹ or rⁿ⁻¹.
    #[inline(always)]
    fn slopes(self, [a, b]: [f32; 2]) -> (f32, [f32; 2]) {
        let (lesser, greater) = if a < b { (a, b) } else { (b, a) };
        let (inside, outside) = (lesser > 0.0, greater < 0.0);
        let ratio = if inside { lesser / greater } else { greater / lesser };
        let ratio = if inside || outside { ratio } else { 0.0 };
        let below = powi::power(ratio, self.order - 1);
        let sum = 1.0 + below * ratio;
        // Of 1 to 2, where log is right to the last bits.
        let root = if self.order == 2 { sum.sqrt() } else { math::exp(math::log(sum) / self.order as f32) };
        let outside_of_one = if outside { lesser * root } else { lesser };
        let value = if inside { lesser / root } else { outside_of_one };
        let first = if inside { 1.0 / (root * sum) } else { root / sum };
        let second = first * if inside { below * ratio * ratio } else { below };
        let (by_lesser, by_greater) = if inside || outside { (first, second) } else { (1.0, 0.0) };
        (value, if a < b { [by_lesser, by_greater] } else { [by_greater, by_lesser] })
    }

    /// By monotony.
    fn bounds(self, [a, b]: [Interval; 2]) -> Interval {
        widened_power(self.value([a.lo, b.lo]), self.value([a.hi, b.hi]))
    }

    /// The gradient is a mean of both operands' or less inside; outside its weights are of length 1 or less, for n ≥ 2.
    fn facts(self, [a, b]: [Facts; 2]) -> Facts {
        Facts::intersection(a, b, steep(a, b))
    }

    /// Where one is not positive and the other not negative, it is the former.
    fn same(self, [a, b]: [Interval; 2]) -> Same {
        match (a, b) {
            _ if a.hi <= 0.0 && b.lo >= 0.0 => Same::Argument(0),
            _ if b.hi <= 0.0 && a.lo >= 0.0 => Same::Argument(1),
            _ => Same::Itself,
        }
    }

    /// With the order known, the loop over its bits is gone and lanes become vectors.
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

/// The slope of an operation of this system.
pub(super) fn steep(a: Facts, b: Facts) -> Slope {
    Facts::steep(a.steepness().zip(b.steepness()).map(|(a, b)| a.hypot(b))).slope
}

/// End points of bounds that went through two powers, each right to a few units in the last place.
pub(super) fn widened_power(lo: f64, hi: f64) -> Interval {
    let slack = |value: f64| 16.0 * f64::EPSILON * value.abs();
    Interval::widened(lo - slack(lo), hi + slack(hi))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The printed formula, with its cases as they are meant.
    fn printed(a: f64, b: f64, n: i32) -> f64 {
        let order = f64::from(n);
        match (a, b) {
            _ if a > 0.0 && b > 0.0 => a * b * (a.powi(n) + b.powi(n)).powf(-1.0 / order),
            _ if a <= 0.0 && b >= 0.0 => a,
            _ if a >= 0.0 && b <= 0.0 => b,
            _ => -(a.abs().powi(n) + b.abs().powi(n)).powf(1.0 / order),
        }
    }

    #[test]
    fn it_is_the_papers_formula() {
        for order in [2, 3, 4, 7, 16] {
            let operation = Binary::CnIntersection { order };
            let union = Binary::CnUnion { order };
            for (a, b) in
                [(1.0, 2.0), (0.3, 0.3), (-1.0, 2.0), (2.0, -0.5), (-1.0, -2.0), (-3.0, -0.1), (0.0, -4.0), (0.0, 1.0)]
            {
                let wanted = printed(a, b, order as i32);
                assert!((operation.value([a, b]) - wanted).abs() < 1e-14, "{order}: {a}, {b}");
                assert!((union.value([-a, -b]) + wanted).abs() < 1e-14, "{order}: {a}, {b}");
                let (value, _) = CnIntersection { order }.slopes([a as f32, b as f32]);
                assert!((f64::from(value) - wanted).abs() < 1e-6, "{order}: {a}, {b}: {value}, {wanted}");
            }
        }
        // No size is too small or too large.
        let tiny = Binary::CnIntersection { order: 16 }.value([1e-200, 1e-200]);
        assert!((tiny / 1e-200 - 2.0_f64.powf(-1.0 / 16.0)).abs() < 1e-14);
    }
}
