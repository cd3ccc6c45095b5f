//! One frame of a morph by space-time blending, as a field in world units.

use std::sync::Arc;

use glam::DVec3;

use super::both::{Both, Parts, has_both_signs, scaled, told_each};
use super::section::{Kernel, Section};
use crate::distance::Distance;
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points, Slope};

/// F_b of two distances at one instant (heterogeneous STB, eq. 5), in world units: F_b of lengths over D, times D.
///
/// Its zero set is the frame's surface; away from it the value has the sign and about the size of a distance, no more.
pub struct Stb {
    first: Arc<dyn Distance>,
    second: Arc<dyn Distance>,
    unit: f64,
    fast: Kernel<f32>,
    exact: Kernel<f64>,
}

impl Stb {
    /// The section of the morph between two distances that stand in the world as they do at this instant; `unit` is D.
    pub fn new(first: Arc<dyn Distance>, second: Arc<dyn Distance>, unit: f64, section: &Section) -> Self {
        Self { first, second, unit, fast: Kernel::new(section), exact: Kernel::new(section) }
    }

    /// How far outside both objects' boxes F_b may still be positive, in units of D: where both distances are the
    /// same. `None` where it never falls, or does not fall with the distances.
    fn reach(&self) -> Option<f64> {
        let outside = |reach: f64| self.exact.rises() && self.exact.value(-reach, -reach) < 0.0;
        let mut far = 1.0 / 64.0;
        while !outside(far) {
            far *= 2.0;
            if far > 1e6 {
                return None;
            }
        }
        let mut near = 0.0;
        for _ in 0..40 {
            let middle = (near + far) * 0.5;
            if outside(middle) { far = middle } else { near = middle }
        }
        Some(far)
    }
}

impl Field for Stb {
    /// The box around both objects' boxes grown by the reach of the blend.
    fn bounding_box(&self) -> Option<Aabb> {
        let both = self.first.bounding_box()?.union(self.second.bounding_box()?);
        Some(both.grown(self.reach()? * self.unit))
    }

    fn slope(&self) -> Slope {
        let steepest = |field: &dyn Distance| match field.slope() {
            Slope::Exact { .. } => Some(1.0),
            Slope::Lipschitz(slope) => Some(slope),
            Slope::Unknown => None,
        };
        match (steepest(self.first.as_ref()), steepest(self.second.as_ref())) {
            (Some(one), Some(two)) => Slope::Lipschitz(self.exact.greatest_slope() * f64::max(one, two)),
            _ => Slope::Unknown,
        }
    }

    fn reference(&self, position: DVec3) -> f64 {
        let of = |field: &dyn Distance| field.reference(position) / self.unit;
        self.exact.value(of(self.first.as_ref()), of(self.second.as_ref())) * self.unit
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(StbEvaluator {
            stb: self,
            both: Both::new(self.first.evaluator(), self.second.evaluator(), self.unit),
            values: [0.0; BATCH],
            gradients: Gradients::new(),
        })
    }
}

struct StbEvaluator<'a> {
    stb: &'a Stb,
    both: Both<'a>,
    values: [f32; BATCH],
    gradients: Gradients,
}

impl Evaluator for StbEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.both.enter(region);
    }

    fn bounds(&mut self) -> Interval {
        let Stb { exact, fast, .. } = self.stb;
        let of_region = |[first, second]: [Interval; 2]| exact.bounds(first, second);
        let of_parts = |parts: &Parts, out: &mut [Interval; BATCH]| {
            if exact.rises() { blend_bounds(fast, parts, out) } else { parts.each(out, of_region) }
        };
        scaled(self.both.bounds_of(of_region, of_parts), self.stb.unit)
    }

    fn hints(&mut self, asked: Hint) -> Hints {
        let region = self.both.region().filter(|_| asked == Hint::Vanishes);
        Hints { vanishes: region.is_some_and(|region| has_both_signs(self, &region)), ..Hints::NONE }
    }

    fn leave(&mut self) {
        self.both.leave();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        self.both.first.values(points, out);
        self.both.second.values(points, &mut self.values);
        let len = points.len;
        blend_values(&self.stb.fast, self.stb.unit as f32, &mut out[..len], &self.values[..len]);
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        self.both.first.gradients(points, out);
        self.both.second.gradients(points, &mut self.gradients);
        blend_gradients(&self.stb.fast, self.stb.unit as f32, points.len, out, &self.gradients);
    }
}

#[multiversion::multiversion(targets = "simd")]
fn blend_values(kernel: &Kernel<f32>, unit: f32, first: &mut [f32], second: &[f32]) {
    let per_unit = 1.0 / unit;
    for (first, second) in first.iter_mut().zip(second) {
        *first = kernel.value(*first * per_unit, *second * per_unit) * unit;
    }
}

/// [`Kernel::bounds`] of an F_b that rises with both distances, over many parts at once.
#[multiversion::multiversion(targets = "simd")]
fn blend_bounds(kernel: &Kernel<f32>, parts: &Parts, out: &mut [Interval; BATCH]) {
    let per_unit = 1.0 / parts.unit as f32;
    let spread = parts.spread.map(|spread| spread as f32);
    let [first, second] = parts.distances;
    let mut ends = [[0.0_f32; BATCH]; 2];
    for (ends, sign) in ends.iter_mut().zip([-1.0, 1.0]) {
        for i in 0..parts.middles.len.min(BATCH) {
            let value = kernel.value(first[i] * per_unit + sign * spread[0], second[i] * per_unit + sign * spread[1]);
            // Once for this value and once for those of the batches to come.
            ends[i] = value + sign * 2.0 * kernel.rounding(value);
        }
    }
    told_each(&ends, parts, out);
}

#[multiversion::multiversion(targets = "simd")]
fn blend_gradients(kernel: &Kernel<f32>, unit: f32, len: usize, first: &mut Gradients, second: &Gradients) {
    let per_unit = 1.0 / unit;
    for i in 0..len {
        let slopes = kernel.slopes(first.value[i] * per_unit, second.value[i] * per_unit);
        first.value[i] = slopes.value * unit;
        first.dx[i] = slopes.by_first * first.dx[i] + slopes.by_second * second.dx[i];
        first.dy[i] = slopes.by_first * first.dy[i] + slopes.by_second * second.dy[i];
        first.dz[i] = slopes.by_first * first.dz[i] + slopes.by_second * second.dz[i];
    }
}
