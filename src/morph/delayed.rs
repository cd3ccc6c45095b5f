//! One frame of a morph whose places wait, as a field in world units.

use std::sync::Arc;

use glam::DVec3;

use super::both::{Both, Parts, has_both_signs, scaled};
use super::course::Course;
use super::delay::DelayGrid;
use crate::distance::Distance;
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Interval, Points, Slope};

/// F_b (heterogeneous STB, eq. 5) of two distances, each place at its own progress; in world units as [`super::Stb`].
pub(super) struct DelayedStb {
    pub first: Arc<dyn Distance>,
    pub second: Arc<dyn Distance>,
    /// D, world units.
    pub unit: f64,
    /// The progress of places that do not wait.
    pub eased: f64,
    pub delay: Arc<DelayGrid>,
    pub course: Arc<Course>,
}

impl Field for DelayedStb {
    fn bounding_box(&self) -> Option<Aabb> {
        let both = self.first.bounding_box()?.union(self.second.bounding_box()?);
        Some(both.grown(self.course.outside()? * self.unit))
    }

    fn slope(&self) -> Slope {
        Slope::Unknown
    }

    fn reference(&self, position: DVec3) -> f64 {
        let of = |field: &dyn Distance| field.reference(position) / self.unit;
        let place = self.course.at(self.delay.local(position, self.eased).progress);
        place.value(of(self.first.as_ref()), of(self.second.as_ref())) * self.unit
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(DelayedEvaluator {
            field: self,
            both: Both::new(self.first.evaluator(), self.second.evaluator(), self.unit),
            values: [0.0; BATCH],
            gradients: Gradients::new(),
        })
    }
}

struct DelayedEvaluator<'a> {
    field: &'a DelayedStb,
    both: Both<'a>,
    values: [f32; BATCH],
    gradients: Gradients,
}

impl Evaluator for DelayedEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.both.enter(region);
    }

    fn bounds(&mut self) -> Interval {
        let DelayedStb { unit, eased, delay, course, .. } = self.field;
        let blend =
            |part: &Aabb, [first, second]: [Interval; 2]| course.bounds(delay.bounds(part, *eased), first, second);
        let of_parts = |parts: &Parts, out: &mut [Interval; BATCH]| parts.each(out, blend);
        scaled(self.both.bounds_of(blend, of_parts), *unit)
    }

    fn vanishes(&mut self) -> bool {
        self.both.region().is_some_and(|region| has_both_signs(self, &region))
    }

    fn leave(&mut self) {
        self.both.leave();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        self.both.first.values(points, out);
        self.both.second.values(points, &mut self.values);
        let DelayedStb { unit, eased, delay, course, .. } = self.field;
        let per_unit = 1.0 / unit;
        for i in 0..points.len {
            let place = course.at(delay.local(points.position(i), *eased).progress);
            let value = place.value(f64::from(out[i]) * per_unit, f64::from(self.values[i]) * per_unit);
            out[i] = (value * unit) as f32;
        }
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        self.both.first.gradients(points, out);
        self.both.second.gradients(points, &mut self.gradients);
        let DelayedStb { unit, eased, delay, course, .. } = self.field;
        let per_unit = 1.0 / unit;
        for i in 0..points.len {
            let local = delay.local(points.position(i), *eased);
            let [first, second] = [out.value[i], self.gradients.value[i]].map(|value| f64::from(value) * per_unit);
            let slopes = course.at(local.progress).slopes(first, second);
            let waiting = if local.gradient == DVec3::ZERO {
                DVec3::ZERO
            } else {
                local.gradient * (course.rate(local.progress, first, second) * unit)
            };
            let gradient = out.gradient(i).as_dvec3() * slopes.by_first
                + self.gradients.gradient(i).as_dvec3() * slopes.by_second
                + waiting;
            out.value[i] = (slopes.value * unit) as f32;
            (out.dx[i], out.dy[i], out.dz[i]) = (gradient.x as f32, gradient.y as f32, gradient.z as f32);
        }
    }
}
