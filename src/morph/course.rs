//! Every section of a morph at once: what a place shows that has a progress of its own.
//!
//! A section hardly changes in its first and last moments, but F_b becomes flat inside the surface there, and cannot be
//! measured: F_b there goes over into the object's distance, which its zero set ends in.

use super::curves::Curves;
use super::dual::Dual;
use super::real::Real;
use super::section::{Kernel, Slopes};
use super::settings::FLOW_TIME_SCALE;
use crate::field::Interval;

/// Sections that are solved, but for the first. Fewer: volumes are off in between; each costs a solve of a₀.
const SOLVED: usize = 32;
/// The share of progress at both ends in which F_b goes over into a distance.
const END: f64 = 0.01;
/// The least t, and the least left to 1, that sections are taken at.
pub(super) const LEAST_TIME: f64 = 1e-3;

/// What varies of a section as the morph goes on, over its progress.
pub(super) struct Course {
    /// Units of D that a unit of t is worth.
    time_scale: f64,
    /// STB's t; a₀ over t(1 − t), which neither vanishes nor grows at the ends; and 1/(a₁²q), which is also 1/(a₂²q).
    curves: Curves<3>,
}

/// One solved section: t, a₀ and 1/(a₁²q).
pub(super) struct Solution {
    pub time: f64,
    pub a0: f64,
    pub reach: f64,
}

/// The blend at one place.
pub(super) struct Place<T> {
    kernel: Kernel<T>,
    /// How much of the first and of the second object's distance counts in place of F_b.
    ends: [T; 2],
}

impl<T: Real> Place<T> {
    fn new(time_scale: f64, [time, amount, reach]: [T; 3], ends: [T; 2]) -> Self {
        let (scale, left) = (T::of(time_scale), T::ONE - time);
        let kernel = Kernel::of_parts([-(scale * time), -(scale * left)], amount * time * left, reach);
        Self { kernel, ends }
    }

    /// The blend, of distances in units of D.
    pub(super) fn value(&self, first: T, second: T) -> T {
        let [one, two] = self.ends;
        self.kernel.value(first, second) * (T::ONE - one - two) + first * one + second * two
    }

    /// The blend with its derivatives by both distances.
    pub(super) fn slopes(&self, first: T, second: T) -> Slopes<T> {
        let [one, two] = self.ends;
        let (blend, rest) = (self.kernel.slopes(first, second), T::ONE - one - two);
        Slopes {
            value: blend.value * rest + first * one + second * two,
            by_first: blend.by_first * rest + one,
            by_second: blend.by_second * rest + two,
        }
    }
}

impl Course {
    /// The progresses at which sections are to be solved: closer towards both ends, where a₀ bends most.
    pub(super) fn nodes() -> Vec<f64> {
        (0..=SOLVED).map(|i| 0.5 - 0.5 * libm::cos(std::f64::consts::PI * i as f64 / SOLVED as f64)).collect()
    }

    /// From the sections solved at the nodes. `None` where one is not finite.
    pub(super) fn new(solved: &[Solution]) -> Option<Self> {
        let at = |one: &Solution| [one.time, one.a0 / (one.time * (1.0 - one.time)), one.reach];
        let points = Self::nodes().into_iter().zip(solved).map(|(node, one)| (node, at(one))).collect();
        Some(Self { time_scale: FLOW_TIME_SCALE, curves: Curves::through(points)? })
    }

    /// a₀ at a progress.
    pub(super) fn a0(&self, progress: f64) -> f64 {
        let [time, amount, _] = self.curves.at(progress);
        amount * time * (1.0 - time)
    }

    /// The blend at a progress.
    pub(super) fn at(&self, progress: f64) -> Place<f64> {
        Place::new(self.time_scale, self.curves.at(progress), ends(progress))
    }

    /// The blend's derivative by the progress, of distances in units of D.
    pub(super) fn rate(&self, progress: f64, first: f64, second: f64) -> f64 {
        let [[one, one_rate], [two, two_rate]] = [end(progress), end(1.0 - progress)];
        let ends = [Dual::new(one, one_rate), Dual::new(two, -two_rate)];
        let place = Place::new(self.time_scale, self.curves.at_with_rates(progress), ends);
        place.value(Dual::of(first), Dual::of(second)).rate
    }

    /// Bounds of the blend for progress and distances within bounds.
    pub(super) fn bounds(&self, progress: Interval, first: Interval, second: Interval) -> Interval {
        if ![first.lo, first.hi, second.lo, second.hi].iter().all(|end| end.is_finite()) {
            return Interval::ALL;
        }
        let [time, amount, reach] = self.curves.range(progress);
        // t(1 − t) is least at an end, and at most a quarter.
        let left = [time.lo, time.hi].map(|time| time * (1.0 - time));
        let most = if time.contains(0.5) { 0.25 } else { left[0].max(left[1]) };
        let a0 = Interval::new(amount.lo * left[0].min(left[1]), amount.hi * most);
        let cut = |lo: f64, hi: f64| Interval::new(-self.time_scale * hi, -self.time_scale * lo);
        let cuts = [cut(time.lo, time.hi), cut(1.0 - time.hi, 1.0 - time.lo)];
        let mut bounds = Kernel::bounds_of_parts(cuts, a0, reach, [first, second]);
        if bounds == Interval::ALL {
            return bounds;
        }
        let [one, two] = [ends(progress.lo), ends(progress.hi)];
        for (weights, distance) in [([two[0], one[0]], first), ([one[1], two[1]], second)] {
            let mix = |weight: f64, blend: f64, own: f64| blend + weight * (own - blend);
            let least = weights.map(|weight| mix(weight, bounds.lo, distance.lo));
            let most = weights.map(|weight| mix(weight, bounds.hi, distance.hi));
            bounds = Interval::new(least[0].min(least[1]), most[0].max(most[1]));
        }
        bounds
    }

    /// How far outside both objects' boxes the blend may still be positive, in units of D; `None` where it never falls.
    pub(super) fn outside(&self) -> Option<f64> {
        let nodes = Self::nodes();
        let inside = |reach: f64| {
            let there = Interval::new(-reach, -reach);
            nodes.windows(2).any(|piece| self.bounds(Interval::new(piece[0], piece[1]), there, there).hi >= 0.0)
        };
        let reach = std::iter::successors(Some(1.0 / 64.0), |reach| Some(reach * 1.25));
        reach.take_while(|reach| *reach < 1e6).find(|reach| !inside(*reach))
    }
}

/// How much of each object's distance counts.
fn ends(progress: f64) -> [f64; 2] {
    [end(progress)[0], end(1.0 - progress)[0]]
}

/// 1 at the end, falling to 0 over [`END`], and its rate.
fn end(progress: f64) -> [f64; 2] {
    let u = (progress / END).clamp(0.0, 1.0);
    [1.0 - u * u * (3.0 - 2.0 * u), -6.0 * u * (1.0 - u) / END]
}
