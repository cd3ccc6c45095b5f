//! One frame of a morph whose places wait, as a field in world units.

use std::sync::Arc;

use glam::DVec3;
use multiversion::multiversion;

use super::both::{Both, Parts, has_both_signs, scaled, told, told_each};
use super::course::{Course, Place, Sections};
use super::curves::Looked;
use super::delay::DelayGrid;
use super::real::Real;
use crate::distance::Distance;
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points, Slope};

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
        let place = self.course.place(self.delay.progress(position, self.eased));
        place.value(of(self.first.as_ref()), of(self.second.as_ref())) * self.unit
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(DelayedEvaluator {
            field: self,
            both: Both::new(self.first.evaluator(), self.second.evaluator(), self.unit),
            second: Gradients::new(),
            progress: Gradients::new(),
            course: Looked::new(),
            ends: Ends { progress: [[0.0; BATCH]; 2], course: [Looked::new(), Looked::new()] },
        })
    }
}

struct DelayedEvaluator<'a> {
    field: &'a DelayedStb,
    both: Both<'a>,
    /// The second object's distances.
    second: Gradients,
    progress: Gradients,
    course: Looked<3>,
    ends: Ends,
}

/// The least and the most progress of parts, and the course at either.
struct Ends {
    progress: [[f32; BATCH]; 2],
    course: [Looked<3>; 2],
}

impl Evaluator for DelayedEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.both.enter(region);
    }

    fn bounds(&mut self) -> Interval {
        let Some(region) = self.both.region() else { return Interval::ALL };
        let DelayedStb { unit, eased, delay, course, .. } = self.field;
        let over = delay.over(&region);
        let all = over.progress(*eased);
        let of_region = |[first, second]: [Interval; 2]| {
            let [lo, hi] = course.sections(all).bounds([first.lo, first.hi], [second.lo, second.hi]);
            told(lo, hi)
        };
        let turns = course.turns(all).map(|turns| [turns.lo as f32, turns.hi as f32]);
        let (delays, ends) = (&mut self.progress, &mut self.ends);
        let of_parts = |parts: &Parts, out: &mut [Interval; BATCH]| {
            delay.bounds_around((parts.middles, parts.size), &over, *eased, delays, &mut ends.progress);
            for (progress, course_there) in ends.progress.iter().zip(&mut ends.course) {
                course.look_up(&progress[..parts.middles.len], false, course_there);
            }
            blend_bounds(ends, &turns, parts, out);
        };
        scaled(self.both.bounds_of(of_region, of_parts), *unit)
    }

    fn hints(&mut self, asked: Hint) -> Hints {
        let region = self.both.region().filter(|_| asked == Hint::Vanishes);
        Hints { vanishes: region.is_some_and(|region| has_both_signs(self, &region)), ..Hints::NONE }
    }

    fn leave(&mut self) {
        self.both.leave();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        let DelayedStb { unit, eased, delay, course, .. } = self.field;
        delay.progresses(points, *eased, &mut self.progress);
        course.look_up(&self.progress.value[..points.len], false, &mut self.course);
        self.both.first.values(points, out);
        self.both.second.values(points, &mut self.second.value);
        blend_values(&self.progress.value, &self.course, *unit as f32, points.len, out, &self.second.value);
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        let DelayedStb { unit, eased, delay, course, .. } = self.field;
        delay.progresses(points, *eased, &mut self.progress);
        course.look_up(&self.progress.value[..points.len], true, &mut self.course);
        self.both.first.gradients(points, out);
        self.both.second.gradients(points, &mut self.second);
        blend_gradients(&self.progress, &self.course, *unit as f32, points.len, out, &self.second);
    }
}

/// Bounds of the blend over parts. `turns` are the course's around all.
#[multiversion(targets = "simd")]
fn blend_bounds(ends: &Ends, turns: &[[f32; 2]; 3], parts: &Parts, out: &mut [Interval; BATCH]) {
    let per_unit = 1.0 / parts.unit as f32;
    let spread = parts.spread.map(|spread| spread as f32);
    let mut bounds = [[0.0_f32; BATCH]; 2];
    for i in 0..parts.middles.len.min(BATCH) {
        let mut between = *turns;
        for n in 0..3 {
            let [from, to] = [&ends.course[0], &ends.course[1]].map(|course| course.values[n][i]);
            let [least, most] = between[n];
            between[n] = [least.least(from).least(to), most.most(from).most(to)];
        }
        let sections = Sections::between([ends.progress[0][i], ends.progress[1][i]], between);
        let [first, second] = [0, 1].map(|object| {
            let value = parts.distances[object][i] * per_unit;
            [value - spread[object], value + spread[object]]
        });
        [bounds[0][i], bounds[1][i]] = sections.bounds(first, second);
    }
    told_each(&bounds, parts, out);
}

#[multiversion(targets = "simd")]
fn blend_values(
    progress: &[f32; BATCH],
    course: &Looked<3>,
    unit: f32,
    len: usize,
    first: &mut [f32; BATCH],
    second: &[f32; BATCH],
) {
    let per_unit = 1.0 / unit;
    let [time, amount, reach] = &course.values;
    for i in 0..len.min(BATCH) {
        let place = Place::new(progress[i], [time[i], amount[i], reach[i]]);
        first[i] = place.value(first[i] * per_unit, second[i] * per_unit) * unit;
    }
}

#[multiversion(targets = "simd")]
fn blend_gradients(
    progress: &Gradients,
    course: &Looked<3>,
    unit: f32,
    len: usize,
    first: &mut Gradients,
    second: &Gradients,
) {
    let per_unit = 1.0 / unit;
    let [[time, amount, reach], [time_rate, amount_rate, reach_rate]] = [&course.values, &course.rates];
    for i in 0..len.min(BATCH) {
        let distances = [first.value[i] * per_unit, second.value[i] * per_unit];
        let (at, rates) = ([time[i], amount[i], reach[i]], [time_rate[i], amount_rate[i], reach_rate[i]]);
        let place = Place::new(progress.value[i], at);
        let slopes = place.slopes(distances[0], distances[1]);
        let by_progress = place.rate(progress.value[i], at, rates, distances) * unit;
        first.value[i] = slopes.value * unit;
        first.dx[i] = slopes.by_first * first.dx[i] + slopes.by_second * second.dx[i] + by_progress * progress.dx[i];
        first.dy[i] = slopes.by_first * first.dy[i] + slopes.by_second * second.dy[i] + by_progress * progress.dy[i];
        first.dz[i] = slopes.by_first * first.dz[i] + slopes.by_second * second.dz[i] + by_progress * progress.dz[i];
    }
}
