//! Interval arithmetic, rounded outward: the bounds that prune.
//!
//! IEEE `+ − × ÷ √` round to within half an ulp, so one step outward suffices for them; functions of `libm` and
//! the short formulas of the set operations are within a few ulps and are widened by [`Interval::widened`].

use std::ops::{Add, Mul, Neg};

use super::Interval;

impl Add for Interval {
    type Output = Self;

    /// Bounds of the sum.
    fn add(self, other: Self) -> Self {
        if self == Self::ZERO {
            return other;
        }
        if other == Self::ZERO {
            return self;
        }
        Self::outward(self.lo + other.lo, self.hi + other.hi)
    }
}

impl Neg for Interval {
    type Output = Self;

    /// Bounds of the negated value.
    fn neg(self) -> Self {
        Self::new(-self.hi, -self.lo)
    }
}

impl Mul for Interval {
    type Output = Self;

    /// Bounds of the product.
    fn mul(self, other: Self) -> Self {
        if self == Self::ZERO || other == Self::ZERO {
            return Self::ZERO;
        }
        // An end at zero times one at infinity bounds finite products, all of them zero.
        let product = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
        let ends = [
            product(self.lo, other.lo),
            product(self.lo, other.hi),
            product(self.hi, other.lo),
            product(self.hi, other.hi),
        ];
        let (least, greatest) = ends
            .into_iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, greatest), end| (least.min(end), greatest.max(end)));
        Self::outward(least, greatest)
    }
}

impl Interval {
    /// Exactly zero.
    pub const ZERO: Self = Self::new(0.0, 0.0);

    /// The interval, or [`Interval::ALL`] where an end is not a number.
    pub(super) fn checked(lo: f64, hi: f64) -> Self {
        if lo.is_nan() || hi.is_nan() { Self::ALL } else { Self { lo, hi } }
    }

    pub(super) fn outward(lo: f64, hi: f64) -> Self {
        Self::checked(lo.next_down(), hi.next_up())
    }

    /// Bounds widened by more than the rounding of a few operations relative to their own size.
    pub(super) fn widened(lo: f64, hi: f64) -> Self {
        const ULPS: f64 = 8.0 * f64::EPSILON;
        Self::checked(lo - lo.abs() * ULPS - f64::MIN_POSITIVE, hi + hi.abs() * ULPS + f64::MIN_POSITIVE)
    }

    /// Bounds of a function that rises (weakly) with its value.
    pub(super) fn rising(self, function: impl Fn(f64) -> f64) -> Self {
        Self::widened(function(self.lo), function(self.hi))
    }

    /// Bounds of the absolute value.
    pub fn abs(self) -> Self {
        match self {
            _ if self.lo >= 0.0 => self,
            _ if self.hi <= 0.0 => -self,
            _ => Self::new(0.0, self.hi.max(-self.lo)),
        }
    }
}
