//! One frame of a morph by space-time blending, as a field in world units.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::both::{Both, scaled};
use super::section::{Kernel, Section};
use crate::distance::Distance;
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Interval, Points, Slope};

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
            regions: Vec::new(),
            values: [0.0; BATCH],
            gradients: Gradients::new(),
        })
    }
}

/// How often parts of a region are halved to bound what they hold. More costs more than blocks opened in vain.
const HALVINGS: usize = 5;

struct StbEvaluator<'a> {
    stb: &'a Stb,
    both: Both<'a>,
    regions: Vec<Aabb>,
    values: [f32; BATCH],
    gradients: Gradients,
}

impl StbEvaluator<'_> {
    /// Bounds from the distances in the middles of the region's parts, in units of D: over a part neither changes by more
    /// than its slope allows on the way to a corner. Narrower than those of the ends of both distances over the region,
    /// which are met in different places of it. Parts that may hold a zero are halved; `None` where some still may.
    fn bounds_by_parts(&mut self, region: &Aabb) -> Option<Interval> {
        let steepest = [self.both.first.steepest()?, self.both.second.steepest()?];
        let mut bounds = Interval::new(f64::INFINITY, f64::NEG_INFINITY);
        let mut part = region.size();
        let mut parts = Points::new(region.centre());
        parts.push(Vec3::ZERO);
        for _ in 0..HALVINGS {
            // The rounding of an f32 value is far below a thousandth of a part.
            let reach = 0.5005 * part.length() / self.stb.unit;
            self.both.first.values(&parts, &mut self.gradients.value);
            self.both.second.values(&parts, &mut self.values);
            part *= 0.5;
            let corners = Aabb::new(-part * 0.5, part * 0.5).corners();
            let mut halves = Points::new(parts.origin);
            for i in 0..parts.len {
                let values = [(self.gradients.value[i], steepest[0]), (self.values[i], steepest[1])];
                let [first, second] = values.map(|(value, slope)| {
                    let value = f64::from(value) / self.stb.unit;
                    Interval::new(value - slope * reach, value + slope * reach)
                });
                let found = self.stb.exact.bounds(first, second);
                if !found.contains(0.0) {
                    bounds = bounds.union(found);
                } else if halves.len + 8 <= BATCH {
                    corners.iter().for_each(|step| halves.push(parts.offset(i) + step.as_vec3()));
                } else {
                    return None;
                }
            }
            if bounds.contains(0.0) {
                return None;
            }
            if halves.len == 0 {
                return Some(bounds);
            }
            parts = halves;
        }
        None
    }
}

impl Evaluator for StbEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.regions.push(*region);
        self.both.enter(region);
    }

    fn bounds(&mut self) -> Interval {
        let Some(region) = self.regions.last().copied() else { return Interval::ALL };
        let unit = self.stb.unit;
        let [first, second] = self.both.bounds();
        let mut bounds = self.stb.exact.bounds(first, second);
        if bounds.contains(0.0)
            && let Some(other) = self.bounds_by_parts(&region)
        {
            bounds = Interval::new(bounds.lo.max(other.lo), bounds.hi.min(other.hi));
        }
        scaled(bounds, unit)
    }

    /// Two signs in a box have a zero between them: a few values cost less than bounds of two objects' cells.
    fn vanishes(&mut self) -> bool {
        let Some(region) = self.regions.last() else { return false };
        let centre = region.centre();
        let mut points = Points::new(centre);
        let half = (region.size() * 0.5).as_vec3();
        points.push(Vec3::ZERO);
        for corner in region.corners() {
            points.push((corner - centre).as_vec3());
        }
        for axis in Vec3::AXES {
            points.push(half * axis);
            points.push(half * -axis);
        }
        let mut values = [0.0; BATCH];
        self.values(&points, &mut values);
        let values = &values[..points.len];
        values.iter().any(|value| *value >= 0.0) && values.iter().any(|value| *value < 0.0)
    }

    fn leave(&mut self) {
        self.regions.pop();
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
