//! Space-time blending at one instant, as a function of the two objects' distances alone.
//!
//! The 4D body of a morph is two half-cylinders along time, joined by a bounded blend (heterogeneous STB, eq. 5 and 6);
//! a frame is its section at one t. All lengths here are in units of D (see [`super::Plan::unit`]).

use super::real::{Real, intersection, intersection_slope, union, union_slope};
use crate::field::Interval;

/// The parameters of space-time blending at one instant, free of units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// STB's time: 0 is the first object, 1 the second.
    pub t: f64,
    /// Units of D a unit of t is worth.
    pub time_scale: f64,
    /// The bounding slab's ends on the time axis.
    pub slab: [f64; 2],
    /// How much the blend adds.
    pub a0: f64,
    /// How far the blend reaches from the first object.
    pub a1: f64,
    /// How far the blend reaches from the second object.
    pub a2: f64,
    /// How soon the slab ends the blend.
    pub a3: f64,
    /// The paper's rounding of each half-cylinder against its cutting plane (eq. 6).
    pub round: Option<Round>,
}

/// A bounded blend of a half-cylinder and the plane that cuts it, bounded a distance beyond the cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Round {
    /// How much the blend adds; negative takes away.
    pub a0: f64,
    /// How far it reaches, in distance and in time.
    pub reach: f64,
    /// How soon the bound ends it.
    pub a3: f64,
    /// How far behind the cut, in t, the bound stands.
    pub depth: f64,
}

/// (1 − r²)³/(1 + r²) with r² = R/(R + q), R = (f₁/a₁)² + (f₂/a₂)² and q = r₂²: with ρ = R/q it is
/// 1/((1 + ρ)²(1 + 2ρ)), which neither overflows nor cancels.
#[derive(Clone, Copy, Debug)]
struct Displacement<T> {
    /// 0 where the bound leaves nothing of the blend.
    amount: T,
    k1: T,
    k2: T,
}

impl<T: Real> Displacement<T> {
    fn new(amount: f64, a1: f64, a2: f64, a3: f64, f3: f64) -> Self {
        let q = if f3 > 0.0 { (f3 / a3) * (f3 / a3) } else { 0.0 };
        if q > 0.0 {
            Self { amount: T::of(amount), k1: T::of(1.0 / (a1 * a1 * q)), k2: T::of(1.0 / (a2 * a2 * q)) }
        } else {
            Self { amount: T::ZERO, k1: T::ZERO, k2: T::ZERO }
        }
    }

    #[inline(always)]
    fn rho(&self, f1: T, f2: T) -> T {
        self.k1 * f1 * f1 + self.k2 * f2 * f2
    }

    /// The blend's shape, 1 at its middle, falling with ρ.
    #[inline(always)]
    fn shape(rho: T) -> T {
        let near = T::ONE + rho;
        T::ONE / (near * near * (near + rho))
    }

    /// −d shape/dρ, falling with ρ.
    #[inline(always)]
    fn fall(rho: T) -> T {
        let near = T::ONE + rho;
        Self::shape(rho) * (T::TWO / near + T::TWO / (near + rho))
    }
}

/// A [`Section`] made ready for one precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kernel<T> {
    cut1: T,
    cut2: T,
    blend: Displacement<T>,
    round: Option<[Displacement<T>; 2]>,
}

/// F_b and its derivatives by the two distances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slopes<T> {
    pub value: T,
    pub by_first: T,
    pub by_second: T,
}

impl<T: Real> Kernel<T> {
    pub(super) fn new(section: &Section) -> Self {
        let Section { t, time_scale: s, slab, .. } = *section;
        let bound = intersection(s * (t - slab[0]), s * (slab[1] - t));
        let round = section.round.map(|round| {
            let beyond =
                |t: f64| Displacement::new(round.a0, round.reach, round.reach, round.a3, s * (t + round.depth));
            [beyond(t), beyond(1.0 - t)]
        });
        Self {
            cut1: T::of(-s * t),
            cut2: T::of(s * (t - 1.0)),
            blend: Displacement::new(section.a0, section.a1, section.a2, section.a3, bound),
            round,
        }
    }

    /// Of what cuts the two half-cylinders, both ≤ 0, what the blend adds, and 1/(a₁²q) = 1/(a₂²q).
    pub(super) fn of_parts([cut1, cut2]: [T; 2], amount: T, reach: T) -> Self {
        Self { cut1, cut2, blend: Displacement { amount, k1: reach, k2: reach }, round: None }
    }

    /// 1/(a₁²q).
    pub(super) fn reach(&self) -> T {
        self.blend.k1
    }

    /// The two half-cylinders: each object, cut off in time.
    #[inline(always)]
    fn cylinders(&self, first: T, second: T) -> [T; 2] {
        let plain = [intersection(first, self.cut1), intersection(second, self.cut2)];
        match self.round {
            None => plain,
            Some([one, two]) => [
                plain[0] + one.amount * Displacement::shape(one.rho(first, self.cut1)),
                plain[1] + two.amount * Displacement::shape(two.rho(second, self.cut2)),
            ],
        }
    }

    /// F_b.
    #[inline(always)]
    pub(super) fn value(&self, first: T, second: T) -> T {
        let [g1, g2] = self.cylinders(first, second);
        union(g1, g2) + self.blend.amount * Displacement::shape(self.blend.rho(g1, g2))
    }

    /// φ = −(g₁ ∨₀ g₂)/disp, for `a0 = 1`: F_b ≥ 0 exactly where φ ≤ a₀, whatever a₀ is.
    #[inline(always)]
    pub(super) fn level(&self, first: T, second: T) -> T {
        let [g1, g2] = self.cylinders(first, second);
        -union(g1, g2) / Displacement::shape(self.blend.rho(g1, g2))
    }

    /// F_b with its derivatives.
    #[inline(always)]
    pub(super) fn slopes(&self, first: T, second: T) -> Slopes<T> {
        self.slopes_with(self.blend.amount, first, second)
    }

    /// φ with the direction in which F_b rises where a₀ = φ; for `a0 = 1`.
    #[inline(always)]
    pub(super) fn level_slopes(&self, first: T, second: T) -> Slopes<T> {
        let level = self.level(first, second);
        Slopes { value: level, ..self.slopes_with(level, first, second) }
    }

    /// What a value computed in `f32` may be off, at most.
    #[inline(always)]
    pub(super) fn rounding(&self, value: T) -> T {
        let size = |value: T| value.most(-value);
        T::of(1e-6) * (T::of(1e-3) + size(self.blend.amount) + size(value))
    }

    /// The derivatives of F_b by g₁ and g₂.
    #[inline(always)]
    fn slopes_by_cylinders(&self, amount: T, [g1, g2]: [T; 2]) -> [T; 2] {
        let fall = amount * Displacement::fall(self.blend.rho(g1, g2));
        [
            union_slope(g1, g2) - fall * T::TWO * self.blend.k1 * g1,
            union_slope(g2, g1) - fall * T::TWO * self.blend.k2 * g2,
        ]
    }

    /// How fast F_b changes as what [`Self::of_parts`] takes does.
    #[inline(always)]
    pub(super) fn rate(&self, cuts: [T; 2], amount: T, reach: T, first: T, second: T) -> T {
        let [g1, g2] = self.cylinders(first, second);
        let rho = self.blend.rho(g1, g2);
        let [by_g1, by_g2] = self.slopes_by_cylinders(self.blend.amount, [g1, g2]);
        by_g1 * intersection_slope(self.cut1, first) * cuts[0]
            + by_g2 * intersection_slope(self.cut2, second) * cuts[1]
            + Displacement::shape(rho) * amount
            - self.blend.amount * Displacement::fall(rho) * (g1 * g1 + g2 * g2) * reach
    }

    #[inline(always)]
    fn slopes_with(&self, amount: T, first: T, second: T) -> Slopes<T> {
        let [g1, g2] = self.cylinders(first, second);
        let [by_g1, by_g2] = self.slopes_by_cylinders(amount, [g1, g2]);
        let mut g1_slope = intersection_slope(first, self.cut1);
        let mut g2_slope = intersection_slope(second, self.cut2);
        if let Some([one, two]) = self.round {
            let fall =
                |d: Displacement<T>, f: T, cut: T| d.amount * Displacement::fall(d.rho(f, cut)) * T::TWO * d.k1 * f;
            g1_slope = g1_slope - fall(one, first, self.cut1);
            g2_slope = g2_slope - fall(two, second, self.cut2);
        }
        Slopes {
            value: union(g1, g2) + amount * Displacement::shape(self.blend.rho(g1, g2)),
            by_first: by_g1 * g1_slope,
            by_second: by_g2 * g2_slope,
        }
    }
}

impl Kernel<f64> {
    /// Whether F_b rises with both distances everywhere: g₁ and g₂ stay ≤ 0 and the blend only adds.
    pub(super) fn rises(&self) -> bool {
        self.cut1 <= 0.0 && self.cut2 <= 0.0 && self.blend.amount >= 0.0 && self.round.is_none()
    }

    /// Bounds of F_b for distances within bounds.
    pub(super) fn bounds(&self, first: Interval, second: Interval) -> Interval {
        let bounds = if self.rises() {
            Interval::new(self.value(first.lo, second.lo), self.value(first.hi, second.hi))
        } else {
            self.bounds_by_terms(first, second)
        };
        if bounds.lo.is_nan() || bounds.hi.is_nan() { Interval::ALL } else { self.rounded_outward(bounds) }
    }

    /// Set operations rise in their arguments, displacements fall with ρ: each term has its own bounds.
    fn bounds_by_terms(&self, first: Interval, second: Interval) -> Interval {
        let mut g1 = Interval::new(intersection(first.lo, self.cut1), intersection(first.hi, self.cut1));
        let mut g2 = Interval::new(intersection(second.lo, self.cut2), intersection(second.hi, self.cut2));
        if let Some([one, two]) = self.round {
            let cut = |value: f64| Interval::new(value, value);
            g1 = sum(g1, one.bounds(first, cut(self.cut1)));
            g2 = sum(g2, two.bounds(second, cut(self.cut2)));
        }
        sum(Interval::new(union(g1.lo, g2.lo), union(g1.hi, g2.hi)), self.blend.bounds(g1, g2))
    }

    /// Wider by what an `f32` batch may be off, so that the bounds hold for it too.
    fn rounded_outward(&self, bounds: Interval) -> Interval {
        let margin = |end: f64| if end.is_finite() { self.rounding(end) } else { 0.0 };
        Interval::new(bounds.lo - margin(bounds.lo), bounds.hi + margin(bounds.hi))
    }

    /// The most that F_b can change as both distances change by one.
    pub(super) fn greatest_slope(&self) -> f64 {
        // Each R₀ slope is at most 2, those of a union sum to at most 2 + √2; √ρ·fall(ρ) is at most 0.76 (at ρ = 0.11).
        let displacement = |d: &Displacement<f64>| d.amount.abs() * 2.0 * 0.76 * (d.k1.sqrt() + d.k2.sqrt());
        let cylinder = 2.0 + self.round.map_or(0.0, |two| displacement(&two[0]).max(displacement(&two[1])));
        (2.0 + std::f64::consts::SQRT_2 + displacement(&self.blend)) * cylinder
    }
}

impl Displacement<f64> {
    fn bounds(&self, f1: Interval, f2: Interval) -> Interval {
        let square = |f: Interval| {
            let (lo, hi) = (f.lo * f.lo, f.hi * f.hi);
            let least = if f.contains(0.0) { 0.0 } else { lo.min(hi) };
            [least, lo.max(hi)]
        };
        let (one, two) = (square(f1), square(f2));
        let shape = |i: usize| Self::shape(self.k1 * one[i] + self.k2 * two[i]);
        let ends = [self.amount * shape(0), self.amount * shape(1)];
        Interval::new(ends[0].min(ends[1]), ends[0].max(ends[1]))
    }
}

fn sum(a: Interval, b: Interval) -> Interval {
    Interval::new(a.lo + b.lo, a.hi + b.hi)
}
