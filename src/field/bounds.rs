//! Interval arithmetic, rounded outward: the bounds that prune.
//!
//! IEEE `+ − × ÷ √` round to within half an ulp, so one step outward suffices for them; functions of `libm` and
//! the short formulas of the set operations are within a few ulps and are widened by [`widened`].

use std::ops::{Add, Mul, Neg, Sub};

use super::Interval;
use super::scalar;

/// A bound widened by more than the rounding of a few operations relative to its own size.
fn widened(lo: f64, hi: f64) -> Interval {
    const ULPS: f64 = 8.0 * f64::EPSILON;
    Interval::checked(lo - lo.abs() * ULPS - f64::MIN_POSITIVE, hi + hi.abs() * ULPS + f64::MIN_POSITIVE)
}

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

impl Sub for Interval {
    type Output = Self;

    /// Bounds of the difference.
    fn sub(self, other: Self) -> Self {
        self + -other
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

    fn outward(lo: f64, hi: f64) -> Self {
        Self::checked(lo.next_down(), hi.next_up())
    }

    /// Whether the interval is a single value.
    pub fn is_point(self) -> bool {
        self.lo == self.hi
    }

    /// Bounds of `scale · value + offset`.
    pub fn linear(self, scale: f64, offset: f64) -> Self {
        if scale == 0.0 || self == Self::ZERO {
            return Self::checked(offset, offset);
        }
        let scaled = match scale {
            1.0 => self,
            -1.0 => -self,
            _ if scale > 0.0 => Self::outward(self.lo * scale, self.hi * scale),
            _ => Self::outward(self.hi * scale, self.lo * scale),
        };
        scaled + Self::new(offset, offset)
    }

    /// Bounds of the reciprocal; everything where zero is possible.
    pub fn recip(self) -> Self {
        if self.contains(0.0) { Self::ALL } else { Self::outward(1.0 / self.hi, 1.0 / self.lo) }
    }

    /// Bounds of the absolute value.
    pub fn abs(self) -> Self {
        match self {
            _ if self.lo >= 0.0 => self,
            _ if self.hi <= 0.0 => -self,
            _ => Self::new(0.0, self.hi.max(-self.lo)),
        }
    }

    /// Bounds of the square.
    pub fn square(self) -> Self {
        if self == Self::ZERO {
            return self;
        }
        let abs = self.abs();
        let lo = if abs.lo == 0.0 { 0.0 } else { (abs.lo * abs.lo).next_down().max(0.0) };
        Self::checked(lo, (abs.hi * abs.hi).next_up())
    }

    /// Bounds of a power with an exponent of at least 1.
    pub fn powi(self, exponent: u32) -> Self {
        let end = |value: f64| scalar::powi(value, exponent);
        let slack = |value: f64| value.abs() * f64::EPSILON * f64::from(exponent) + f64::MIN_POSITIVE;
        if exponent.is_multiple_of(2) {
            let abs = self.abs();
            let (lo, hi) = (end(abs.lo), end(abs.hi));
            return Self::checked((lo - slack(lo)).max(0.0), hi + slack(hi));
        }
        let (lo, hi) = (end(self.lo), end(self.hi));
        Self::checked(lo - slack(lo), hi + slack(hi))
    }

    /// Bounds of the square root; everything where it may be undefined.
    pub fn sqrt(self) -> Self {
        if self.lo < 0.0 {
            return Self::ALL;
        }
        let lo = if self.lo == 0.0 { 0.0 } else { self.lo.sqrt().next_down() };
        Self::checked(lo, if self.hi == 0.0 { 0.0 } else { self.hi.sqrt().next_up() })
    }

    /// Bounds of the lesser value.
    pub fn min(self, other: Self) -> Self {
        Self::new(self.lo.min(other.lo), self.hi.min(other.hi))
    }

    /// Bounds of the greater value.
    pub fn max(self, other: Self) -> Self {
        Self::new(self.lo.max(other.lo), self.hi.max(other.hi))
    }

    /// Bounds of a function that rises (weakly) with its value.
    pub(super) fn rising(self, function: impl Fn(f64) -> f64) -> Self {
        widened(function(self.lo), function(self.hi))
    }

    /// Bounds of a function that rises (weakly) with both values: its two end points.
    fn rising_in_both(self, other: Self, function: impl Fn(f64, f64) -> f64) -> Self {
        widened(function(self.lo, other.lo), function(self.hi, other.hi))
    }

    /// Bounds of the R₀ union, by monotony: its plain interval form is far looser.
    pub fn r0_union(self, other: Self) -> Self {
        self.rising_in_both(other, scalar::r0_union)
    }

    /// Bounds of the R₀ intersection, by monotony.
    pub fn r0_intersection(self, other: Self) -> Self {
        self.rising_in_both(other, scalar::r0_intersection)
    }

    /// Bounds of the exact intersection at a right angle, by monotony.
    pub(super) fn corner(self, other: Self) -> Self {
        self.rising_in_both(other, scalar::corner)
    }

    /// Bounds of the bounded blend's displacement: it falls with r₁² and rises with r₂².
    pub(super) fn displacement(self, other: Self) -> Self {
        if other.hi <= 0.0 {
            return Self::ZERO;
        }
        let end = |first: f64, second: f64| scalar::displacement(first.max(0.0), second.max(0.0));
        let bounds = widened(end(self.hi, other.lo), end(self.lo, other.hi));
        Self::new(bounds.lo.max(0.0), bounds.hi.min(1.0))
    }

    /// Bounds of the sine.
    pub fn sin(self) -> Self {
        use std::f64::consts::{FRAC_PI_2, TAU};
        if self.hi - self.lo >= TAU || self.lo.abs().max(self.hi.abs()) > 1e5 {
            return Self::new(-1.0, 1.0);
        }
        // Whether a point phase + k·2π lies in the interval; a near miss counts, so that rounding cannot hide one.
        let meets = |phase: f64| {
            let next = phase + ((self.lo - phase) / TAU - 1e-9).ceil() * TAU;
            next <= self.hi + 1e-8
        };
        let ends = (libm::sin(self.lo), libm::sin(self.hi));
        let lo = if meets(-FRAC_PI_2) { -1.0 } else { ends.0.min(ends.1) };
        let hi = if meets(FRAC_PI_2) { 1.0 } else { ends.0.max(ends.1) };
        let both = widened(lo, hi);
        Self::new(both.lo.max(-1.0), both.hi.min(1.0))
    }

    /// Bounds of the cosine.
    pub fn cos(self) -> Self {
        use std::f64::consts::FRAC_PI_2;
        (self + Self::new(FRAC_PI_2, FRAC_PI_2).rising(|v| v)).sin()
    }

    /// Bounds of the exponential.
    pub fn exp(self) -> Self {
        let bounds = self.rising(scalar::exp);
        Self::new(bounds.lo.max(0.0), bounds.hi)
    }

    /// Bounds of the natural logarithm; everything where it may be undefined.
    pub fn log(self) -> Self {
        if self.lo < 0.0 || self.hi <= 0.0 { Self::ALL } else { self.rising(scalar::log) }
    }

    /// Bounds of a power of a positive base; everything where it may be undefined.
    pub fn pow(self, exponent: Self) -> Self {
        let positive = self.lo > 0.0 || (self.lo == 0.0 && exponent.lo > 0.0);
        if positive { (self.log() * exponent).exp() } else { Self::ALL }
    }

    /// Bounds of the angle of (x, y) = (`x`, `self`).
    pub fn atan2(self, x: Self) -> Self {
        use std::f64::consts::PI;
        if x.lo <= 0.0 && self.contains(0.0) {
            return widened(-PI, PI);
        }
        // Away from the cut the angle over a box is extreme at corners.
        let ends = [(self.lo, x.lo), (self.lo, x.hi), (self.hi, x.lo), (self.hi, x.hi)].map(|(y, x)| libm::atan2(y, x));
        widened(ends.into_iter().fold(PI, f64::min), ends.into_iter().fold(-PI, f64::max))
    }
}
