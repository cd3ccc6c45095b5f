//! The two precisions a formula of this room is written for.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// `f32` in the batches, `f64` in references and bounds: one formula for both.
pub(super) trait Real:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    const ZERO: Self;
    const ONE: Self;
    const TWO: Self;
    /// The least normal number: what a length is at least, where it divides.
    const TINY: Self;

    fn of(value: f64) -> Self;
    fn sqrt(self) -> Self;

    #[inline(always)]
    fn least(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn most(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
}

impl Real for f32 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const TWO: Self = 2.0;
    const TINY: Self = Self::MIN_POSITIVE;

    #[inline(always)]
    fn of(value: f64) -> Self {
        value as f32
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

impl Real for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const TWO: Self = 2.0;
    const TINY: Self = Self::MIN_POSITIVE;

    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

/// R₀ intersection, a + b − √(a² + b²), without the cancellation that gives wrong signs where one argument is small:
/// with m ≤ M it is m − m²/(s + M) for M > 0.
#[inline(always)]
pub(super) fn intersection<T: Real>(a: T, b: T) -> T {
    let (least, most) = (a.least(b), a.most(b));
    // As the slopes have it, so that it is worked out once for all of them.
    let length = (a * a + b * b).sqrt();
    let both = least - least * least / (length + most).most(T::TINY);
    if most > T::ZERO { both } else { least + most - length }
}

/// R₀ union, a + b + √(a² + b²).
#[inline(always)]
pub(super) fn union<T: Real>(a: T, b: T) -> T {
    -intersection(-a, -b)
}

/// ∂(a ∧₀ b)/∂a, in \[0, 2\].
#[inline(always)]
pub(super) fn intersection_slope<T: Real>(a: T, b: T) -> T {
    T::ONE - a / (a * a + b * b).sqrt().most(T::TINY)
}

/// ∂(a ∨₀ b)/∂a, in \[0, 2\].
#[inline(always)]
pub(super) fn union_slope<T: Real>(a: T, b: T) -> T {
    T::ONE + a / (a * a + b * b).sqrt().most(T::TINY)
}
