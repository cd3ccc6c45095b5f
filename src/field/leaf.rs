//! The leaves of an expression that are closed under affine maps: affine forms and sums of their squares.
//!
//! Coefficients are `f64`; a batch's `f64` origin is folded into the constants before anything is rounded to
//! `f32`, so that a surface far from the world's origin keeps its accuracy.

use glam::{DAffine3, DVec3};

use super::{Aabb, Interval};

/// `slope · p + constant`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine {
    pub slope: DVec3,
    pub constant: f64,
}

impl Affine {
    pub const ZERO: Self = Self::constant(0.0);

    pub const fn new(slope: DVec3, constant: f64) -> Self {
        Self { slope, constant }
    }

    pub const fn constant(value: f64) -> Self {
        Self { slope: DVec3::ZERO, constant: value }
    }

    pub fn is_constant(&self) -> bool {
        self.slope == DVec3::ZERO
    }

    /// The form with every negative zero made positive, so that equal forms have equal bits.
    pub fn tidy(self) -> Self {
        Self { slope: self.slope + 0.0, constant: self.constant + 0.0 }
    }

    pub fn at(&self, position: DVec3) -> f64 {
        self.slope.dot(position) + self.constant
    }

    /// The form read at `map(p)`.
    pub fn after(&self, map: &DAffine3) -> Self {
        Self::new(map.matrix3.transpose() * self.slope, self.at(map.translation)).tidy()
    }

    /// `scale · self + offset`.
    pub fn linear(&self, scale: f64, offset: f64) -> Self {
        Self::new(self.slope * scale, self.constant * scale + offset).tidy()
    }

    pub fn plus(&self, other: &Self) -> Self {
        Self::new(self.slope + other.slope, self.constant + other.constant).tidy()
    }

    /// Bounds over a box, rounded outward.
    pub fn bounds(&self, region: &Aabb) -> Interval {
        let (mut least, mut most) = (self.constant, self.constant);
        let (mut below, mut above) = (self.constant.abs(), self.constant.abs());
        for axis in 0..3 {
            // A form that does not change along an axis does not at its far ends either. Without a branch: which axes
            // a form changes along is different from one to the next.
            let slope = self.slope[axis];
            let at = |end: f64| if slope == 0.0 { 0.0 } else { slope * end };
            let (from, to) = (at(region.min[axis]), at(region.max[axis]));
            let (from, to) = (if from < to { from } else { to }, if from < to { to } else { from });
            least += from;
            most += to;
            below += from.abs();
            above += to.abs();
        }
        // Three products and three sums round to within 6 half-ulps of the largest magnitude that occurs. A constant is
        // what it is.
        const SLACK: f64 = 4.0 * f64::EPSILON;
        let slack = if self.is_constant() { 0.0 } else { SLACK };
        Interval::checked(least - slack * below, most + slack * above)
    }

    /// The `f32` form for offsets from an origin: three coefficients and the constant there.
    pub fn around(&self, origin: DVec3) -> [f32; 4] {
        let slope = self.slope.as_vec3();
        [slope.x, slope.y, slope.z, self.at(origin) as f32]
    }
}

/// `constant + Σ weight · form²`, up to three terms; an unused term has weight 0 and the zero form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Quadric {
    pub constant: f64,
    pub terms: [(f64, Affine); 3],
}

impl Quadric {
    const NO_TERM: (f64, Affine) = (0.0, Affine::ZERO);

    pub const fn constant(value: f64) -> Self {
        Self { constant: value, terms: [Self::NO_TERM; 3] }
    }

    pub fn square(form: Affine) -> Self {
        Self { constant: 0.0, terms: [(1.0, form), Self::NO_TERM, Self::NO_TERM] }
    }

    fn used(&self) -> usize {
        self.terms.iter().filter(|(weight, _)| *weight != 0.0).count()
    }

    pub fn at(&self, position: DVec3) -> f64 {
        self.terms.iter().fold(self.constant, |sum, (weight, form)| {
            let value = form.at(position);
            sum + weight * (value * value)
        })
    }

    pub fn after(&self, map: &DAffine3) -> Self {
        Self { constant: self.constant, terms: self.terms.map(|(weight, form)| (weight, form.after(map))) }
    }

    pub fn linear(&self, scale: f64, offset: f64) -> Self {
        if scale == 0.0 {
            return Self::constant(offset);
        }
        let terms = self.terms.map(|(weight, form)| (weight * scale + 0.0, form));
        Self { constant: self.constant * scale + offset, terms }
    }

    /// The sum, or `None` where it has more than three terms.
    pub fn plus(&self, other: &Self) -> Option<Self> {
        let mut sum = Self { constant: self.constant + other.constant, ..*self };
        if self.used() + other.used() > 3 {
            return None;
        }
        let added = other.terms.iter().filter(|(weight, _)| *weight != 0.0);
        for (place, term) in sum.terms[self.used()..].iter_mut().zip(added) {
            *place = *term;
        }
        Some(sum)
    }

    /// Bounds over a box, rounded outward; tight where the forms vary independently.
    pub fn bounds(&self, region: &Aabb) -> Interval {
        let (mut lo, mut hi) = (self.constant, self.constant);
        let (mut below, mut above) = (self.constant.abs(), self.constant.abs());
        let mut slack = 0.0;
        for (weight, form) in &self.terms {
            if *weight == 0.0 {
                continue;
            }
            // Two products a term, and three sums, round to within 6 half-ulps of the largest magnitude that occurs. A
            // constant is what it is.
            slack = 8.0 * f64::EPSILON;
            let ends = form.bounds(region);
            let (one, two) = (ends.lo * ends.lo, ends.hi * ends.hi);
            let (lesser, greater) = if one < two { (one, two) } else { (two, one) };
            let least = if ends.contains(0.0) { 0.0 } else { lesser };
            // A square too small for a number is still one.
            let most = if ends == Interval::ZERO { 0.0 } else { greater.max(f64::MIN_POSITIVE) };
            let (from, to) =
                if *weight > 0.0 { (weight * least, weight * most) } else { (weight * most, weight * least) };
            lo += from;
            hi += to;
            below += from.abs();
            above += to.abs();
        }
        Interval::checked(lo - slack * below, hi + slack * above)
    }

    /// A bound of the slope of `√self`, where `self` is a sum of squares without a constant.
    pub fn root_slope(&self) -> Option<f64> {
        if self.constant != 0.0 || self.terms.iter().any(|(weight, _)| *weight < 0.0) {
            return None;
        }
        let rows = self.terms.map(|(weight, form)| form.slope * weight.sqrt());
        let squares = rows.map(|row| row.length_squared());
        let total: f64 = squares.iter().sum();
        let crossed = [(0, 1), (0, 2), (1, 2)].iter().any(|&(i, j)| rows[i].dot(rows[j]).abs() > 1e-12 * total);
        let largest = squares.into_iter().fold(0.0, f64::max);
        Some(if crossed { total } else { largest * (1.0 + 1e-11) }.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_origin_far_away_costs_no_accuracy() {
        let form = Affine::new(DVec3::X, -100_000.0);
        let origin = DVec3::new(100_000.125, 3.0, 4.0);
        assert_eq!(form.around(origin), [1.0, 0.0, 0.0, 0.125]);
    }

    #[test]
    fn sums_of_squares_stop_at_three_terms() {
        let square = Quadric::square(Affine::new(DVec3::X, 1.0));
        let three = square.plus(&square).and_then(|two| two.plus(&square)).expect("three terms fit");
        assert_eq!(three.at(DVec3::new(1.0, 0.0, 0.0)), 12.0);
        assert_eq!(three.plus(&square), None);
    }
}
