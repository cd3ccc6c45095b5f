//! The union of system R_m, `(a + b + √(a² + b²))·(a² + b²)^(m/2)`: m times differentiable also where both are zero.
//!
//! Rvachev, Theory of R-functions, 1982; methods of FRep. Where surfaces meet F is level, and far from both it grows with
//! the power m + 1 of their size: there is no bound of its slope, and it does not rise with each operand everywhere.

use super::*;

impl Operation<2> for RmUnion {
    const NATURE: Nature = Nature::UNION;

    fn value(self, [a, b]: [f64; 2]) -> f64 {
        let base = Binary::Union.value([a, b]);
        if base == 0.0 || base.is_infinite() {
            return base;
        }
        let square = a * a + b * b;
        let whole = Unary::Powi { exponent: self.order / 2 }.value([square]);
        let power = if self.order.is_multiple_of(2) { whole } else { whole * square.sqrt() };
        // A side is kept at any size.
        (base.abs() * power).clamp(f64::MIN_POSITIVE, f64::MAX).copysign(base)
    }

    /// With r² = a² + b² and the union u of R₀, the derivative by a is rᵐ·(1 + a/r) + m·rᵐ⁻²·a·u.
    #[inline(always)]
    fn slopes(self, [a, b]: [f32; 2]) -> (f32, [f32; 2]) {
        let (base, by) = Union {}.slopes([a, b]);
        let square = a * a + b * b;
        let root = square.sqrt();
        let even = self.order & 1 == 0;
        let whole = powi::power(square, self.order / 2);
        let power = if even { whole } else { whole * root };
        let size = base.abs() * power;
        let size = if size > f32::MIN_POSITIVE { size } else { f32::MIN_POSITIVE };
        let size = if size < f32::MAX { size } else { f32::MAX };
        let signed = if base < 0.0 { -size } else { size };
        let value = if base == 0.0 { base } else { signed };
        let grows = self.order as f32 * base * (power / square);
        let smooth = root > 0.0;
        // Of a size that no float holds the direction is left.
        let slope = |by: f32, operand: f32| {
            let slope = power * by + grows * operand;
            let slope = if slope.abs() < f32::MAX { slope } else { by };
            if smooth { slope } else { 0.0 }
        };
        (value, [slope(by[0], a), slope(by[1], b)])
    }

    /// That of R₀ by monotony, times those of the power.
    fn bounds(self, [a, b]: [Interval; 2]) -> Interval {
        let base = Binary::Union.bounds([a, b]);
        let square = Unary::Square.bounds([a]) + Unary::Square.bounds([b]);
        let whole = match self.order / 2 {
            0 => Interval::new(1.0, 1.0),
            1 => square,
            exponent => Unary::Powi { exponent }.bounds([square]),
        };
        let square = Interval::new(square.lo.max(0.0), square.hi);
        let power = if self.order.is_multiple_of(2) { whole } else { whole * Unary::Sqrt.bounds([square]) };
        let product = base * Interval::new(power.lo.max(0.0), power.hi);
        Interval::widened(product.lo, product.hi)
    }

    fn facts(self, [a, b]: [Facts; 2]) -> Facts {
        Facts::union(a, b, Slope::Unknown, 0.0)
    }

    #[inline(always)]
    fn visit(self, visitor: impl Visitor<2>) {
        with_order(self.order, |order| visitor.visit(Self { order }));
    }
}

/// Does something of an order. With that known, the loop over its bits is gone and lanes become vectors.
#[inline(always)]
pub(super) fn with_order(order: u32, act: impl FnOnce(u32)) {
    match order {
        1 => act(1),
        2 => act(2),
        3 => act(3),
        4 => act(4),
        _ => act(order),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_formula() {
        for order in 1..=8 {
            let (union, intersection) = (Binary::RmUnion { order }, Binary::RmIntersection { order });
            for (a, b) in [(1.0, 2.0), (-1.0, 2.0), (0.7, -0.5), (-1.0, -2.0), (0.3, 0.3), (0.0, -1.3), (-1.3, 0.0)] {
                let (a, b): (f64, f64) = (a, b);
                let power = (a * a + b * b).powf(f64::from(order) / 2.0);
                let wanted = (a + b + a.hypot(b)) * power;
                assert!((union.value([a, b]) - wanted).abs() < 1e-13 * (1.0 + power), "{order}: {a}, {b}");
                let met = (a + b - a.hypot(b)) * power;
                assert!((intersection.value([a, b]) - met).abs() < 1e-13 * (1.0 + power), "{order}: {a}, {b}");
            }
        }
    }

    /// Powers that leave the range of numbers keep the side.
    #[test]
    fn no_size_loses_its_side() {
        for order in [1, 2, 8] {
            for size in [1e-100, 1e-12, 1e12, 1e100] {
                for (a, b) in [(size, size), (size, -size), (-size, -size)] {
                    let wanted = if a > 0.0 || b > 0.0 { 1.0 } else { -1.0 };
                    let (union, other) = (Binary::RmUnion { order }, Binary::RmIntersection { order });
                    assert_eq!(union.value([a, b]).signum(), wanted, "{order}: {a}, {b}");
                    assert_eq!(other.value([-a, -b]).signum(), -wanted, "{order}: {a}, {b}");
                    if size < 1e18 && size > 1e-18 {
                        let (value, by) = RmUnion { order }.slopes([a as f32, b as f32]);
                        assert_eq!(f64::from(value).signum(), wanted, "{order}: {a}, {b}");
                        assert!(value.is_finite() && value != 0.0 && by.iter().all(|by| !by.is_nan()));
                    }
                }
            }
        }
    }

    /// A corner that R₀ has is gone: across the line where two surfaces meet the gradient does not jump.
    #[test]
    fn it_is_smooth_where_surfaces_meet() {
        for step in [1e-3_f32, 1e-6] {
            let (_, one) = RmUnion { order: 2 }.slopes([step, -step]);
            let (_, other) = RmUnion { order: 2 }.slopes([-step, step]);
            assert!(one.iter().zip(other).all(|(one, other)| (one - other).abs() < 9.0 * step * step));
        }
    }
}
