//! A number with its rate of change, so that a formula written for a [`Real`] gives its derivative too.

use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::real::Real;

/// a + b·ε with ε² = 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dual {
    pub value: f64,
    pub rate: f64,
}

impl Dual {
    pub(super) fn new(value: f64, rate: f64) -> Self {
        Self { value, rate }
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.value + other.value, self.rate + other.rate)
    }
}

impl Sub for Dual {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.value - other.value, self.rate - other.rate)
    }
}

impl Mul for Dual {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::new(self.value * other.value, self.rate * other.value + self.value * other.rate)
    }
}

impl Div for Dual {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self::new(value, (self.rate - value * other.rate) / other.value)
    }
}

impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.value, -self.rate)
    }
}

impl PartialEq for Dual {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl PartialOrd for Dual {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.value.partial_cmp(&other.value)
    }
}

impl Real for Dual {
    const ZERO: Self = Self { value: 0.0, rate: 0.0 };
    const ONE: Self = Self { value: 1.0, rate: 0.0 };
    const TWO: Self = Self { value: 2.0, rate: 0.0 };
    const TINY: Self = Self { value: f64::MIN_POSITIVE, rate: 0.0 };

    /// Of two equal ones [`Real::least`] gives the other: between them they give both, so that no rate is lost.
    fn most(self, other: Self) -> Self {
        if self < other { other } else { self }
    }

    fn of(value: f64) -> Self {
        Self::new(value, 0.0)
    }

    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        Self::new(root, self.rate / (2.0 * root).max(f64::MIN_POSITIVE))
    }
}
