//! Space-time transfinite interpolation: how much of each object's attributes a point has, and a frame's mixed
//! attributes.

use std::sync::Arc;

use super::both::Both;
use super::delay::DelayGrid;
use super::real::{Real, intersection};
use crate::attribute::{Attribute, Mix, Sampler};
use crate::field::{Aabb, BATCH, Field, Gradients, Interval, Points};

/// STTI's parameters at one instant, free of units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transfer {
    /// The scene's even time over the span of the colours, not STB's: 0 is the first object's colour, 1 the second's.
    /// Past 1 the second object's colour creeps on outward.
    pub time: f64,
    /// α, ≥ 0: how much time counts beside distance.
    pub alpha: f64,
    /// β in \[0, 1\]; 0.5 favours neither object.
    pub beta: f64,
}

/// How far a weight in `f32` is taken to be from that in `f64`, at most.
const WEIGHT_SLACK: f64 = 1e-5;

/// A [`Transfer`] made ready for one precision.
#[derive(Clone, Copy, Debug)]
struct Weights<T> {
    first_scale: T,
    first_cut: T,
    second_scale: T,
    second_cut: T,
    /// The weight where neither object is any further than the other.
    level: T,
}

impl<T: Real> Weights<T> {
    fn new(transfer: &Transfer) -> Self {
        Self::at(transfer, T::of(transfer.time))
    }

    /// At another time.
    #[inline(always)]
    fn at(transfer: &Transfer, time: T) -> Self {
        let (alpha, beta) = (T::of(transfer.alpha), transfer.beta);
        Self {
            first_scale: T::of(2.0 * (1.0 - beta)),
            first_cut: -(alpha * time),
            second_scale: T::of(2.0 * beta),
            second_cut: alpha * (time - T::ONE),
            level: time.most(T::ZERO).least(T::ONE),
        }
    }

    /// w₂ = g₁/(g₁ + g₂), of distances in units of D; w₁ = 1 − w₂.
    #[inline(always)]
    fn second(&self, first: T, second: T) -> T {
        let g1 = intersection(first * self.first_scale, self.first_cut).least(T::ZERO);
        let g2 = intersection(second * self.second_scale, self.second_cut).least(T::ZERO);
        let sum = g1 + g2;
        if sum < T::ZERO { g1 / sum } else { self.level }
    }
}

impl Weights<f64> {
    /// Bounds of w₂ for distances within bounds: it falls as the first rises and rises with the second.
    fn second_bounds(&self, first: Interval, second: Interval) -> Interval {
        let [g1, g2] = [first.hi * self.first_scale, second.hi * self.second_scale];
        // Where both are 0 the weight jumps to that of time. Infinite distances are no numbers here.
        let may_jump = intersection(g1, self.first_cut) >= 0.0 && intersection(g2, self.second_cut) >= 0.0;
        if may_jump || ![first.lo, first.hi, second.lo, second.hi].into_iter().all(f64::is_finite) {
            return Interval::new(0.0, 1.0);
        }
        let (least, greatest) = (self.second(first.hi, second.lo), self.second(first.lo, second.hi));
        Interval::new((least - WEIGHT_SLACK).max(0.0), (greatest + WEIGHT_SLACK).min(1.0))
    }
}

impl Transfer {
    /// The second colour's weight in \[0, 1\] where the objects' signed distances are these, in units of D.
    pub fn weight(&self, first: f64, second: f64) -> f64 {
        Weights::<f64>::new(self).second(first, second)
    }
}

/// A frame's attribute: that of both objects at the point itself, mixed by [`Transfer`]. Distances and attributes stand
/// in the world as they do at this instant.
pub struct MorphAttribute<const N: usize, M> {
    /// The first object.
    pub first: Arc<dyn Field>,
    /// The second object.
    pub second: Arc<dyn Field>,
    /// The first object's attribute.
    pub from: Arc<dyn Attribute<N>>,
    /// The second object's attribute.
    pub to: Arc<dyn Attribute<N>>,
    /// D, world units.
    pub unit: f64,
    /// The weights.
    pub transfer: Transfer,
    /// Where the time of the weights starts later.
    pub(super) delay: Option<Arc<DelayGrid>>,
    /// The mixing.
    pub mix: M,
}

impl<const N: usize, M: Mix<N>> MorphAttribute<N, M> {
    /// From the distances and the attributes of the first and of the second object, where no place waits.
    pub fn new(
        [first, second]: [Arc<dyn Field>; 2],
        [from, to]: [Arc<dyn Attribute<N>>; 2],
        unit: f64,
        transfer: Transfer,
        mix: M,
    ) -> Self {
        Self { first, second, from, to, unit, transfer, delay: None, mix }
    }
}

impl<const N: usize, M: Mix<N>> Attribute<N> for MorphAttribute<N, M> {
    fn sampler(&self) -> Box<dyn Sampler<N> + '_> {
        Box::new(MorphSampler {
            mix: self.mix,
            transfer: self.transfer,
            delay: self.delay.as_deref(),
            per_unit: (1.0 / self.unit) as f32,
            both: Both::new(self.first.evaluator(), self.second.evaluator(), self.unit),
            from: self.from.sampler(),
            to: self.to.sampler(),
            distances: [[0.0; BATCH]; 2],
            values: [[0.0; N]; BATCH],
            slopes: None,
            times: None,
        })
    }
}

struct MorphSampler<'a, const N: usize, M> {
    mix: M,
    transfer: Transfer,
    delay: Option<&'a DelayGrid>,
    per_unit: f32,
    both: Both<'a>,
    from: Box<dyn Sampler<N> + 'a>,
    to: Box<dyn Sampler<N> + 'a>,
    distances: [[f32; BATCH]; 2],
    values: [[f32; N]; BATCH],
    slopes: Option<Box<Slopes<N>>>,
    /// Where places wait, the time at each.
    times: Option<Box<Gradients>>,
}

/// Scratch memory for gradients.
struct Slopes<const N: usize> {
    /// The distances'.
    distances: [Gradients; 2],
    /// The second object's numbers'.
    to: [Gradients; N],
    /// The weights with the first and with the second distance a little less, and a little more.
    weights: [[[f32; BATCH]; 2]; 2],
}

impl<const N: usize> Default for Slopes<N> {
    fn default() -> Self {
        Self {
            distances: Default::default(),
            to: std::array::from_fn(|_| Gradients::new()),
            weights: [[[0.0; BATCH]; 2]; 2],
        }
    }
}

/// What distances are taken apart for the slopes of weights, in units of D.
const WEIGHT_STEP: f32 = 1.0 / 4096.0;

impl<const N: usize, M: Mix<N>> Sampler<N> for MorphSampler<'_, N, M> {
    fn enter(&mut self, region: &Aabb) {
        self.both.enter(region);
        self.from.enter(region);
        self.to.enter(region);
    }

    fn leave(&mut self) {
        self.both.leave();
        self.from.leave();
        self.to.leave();
    }

    fn sample(&mut self, points: &Points, out: &mut [[f32; N]; BATCH]) {
        let [first, second] = &mut self.distances;
        self.both.first.values(points, first);
        self.both.second.values(points, second);
        let (first_ones, second_ones) = (&mut first[..points.len], &second[..points.len]);
        let per_unit = self.per_unit;
        match self.delay {
            None => second_weights(&Weights::new(&self.transfer), per_unit, first_ones, second_ones),
            Some(delay) => {
                let times = &mut **self.times.get_or_insert_default();
                delay.colour_times(points, self.transfer.time, times);
                let times = &times.value[..points.len];
                second_weights_in_time(&self.transfer, times, per_unit, first_ones, second_ones);
            }
        }
        let weights = first;
        self.from.sample(points, out);
        self.to.sample(points, &mut self.values);
        self.mix.mix_batch(out, &self.values, weights, points.len);
    }

    /// By the distances' own gradients. The weights' slopes over the distances are differences: they cost little.
    fn gradients(&mut self, points: &Points, out: &mut [Gradients; N]) -> bool {
        if self.delay.is_some() || !self.mix.is_straight() {
            return false;
        }
        let slopes = &mut **self.slopes.get_or_insert_default();
        if !self.from.gradients(points, out) || !self.to.gradients(points, &mut slopes.to) {
            return false;
        }
        let len = points.len;
        let [one, two] = &mut slopes.distances;
        self.both.first.gradients(points, one);
        self.both.second.gradients(points, two);
        let weights = Weights::new(&self.transfer);
        let step = WEIGHT_STEP / self.per_unit;
        for (which, sides) in slopes.weights.iter_mut().enumerate() {
            let [first, second] = [0, 1].map(|distance| if distance == which { step } else { 0.0 });
            for (sign, out) in [-1.0, 1.0].into_iter().zip(sides) {
                let other = &mut self.distances[1];
                for i in 0..len {
                    out[i] = one.value[i] + sign * first;
                    other[i] = two.value[i] + sign * second;
                }
                second_weights(&weights, self.per_unit, &mut out[..len], &other[..len]);
            }
        }
        let weight = &mut self.distances[0];
        weight[..len].copy_from_slice(&one.value[..len]);
        second_weights(&weights, self.per_unit, &mut weight[..len], &two.value[..len]);
        let per_step = 0.5 / step;
        let [by_first, by_second] = &slopes.weights;
        for (out, to) in out.iter_mut().zip(&slopes.to) {
            for i in 0..len {
                let [first, second] = [by_first, by_second].map(|[less, more]| (more[i] - less[i]) * per_step);
                let rise = to.value[i] - out.value[i];
                let own = out.gradient(i) * (1.0 - weight[i]) + to.gradient(i) * weight[i];
                let gradient = own + (one.gradient(i) * first + two.gradient(i) * second) * rise;
                out.value[i] += weight[i] * rise;
                (out.dx[i], out.dy[i], out.dz[i]) = gradient.into();
            }
        }
        true
    }

    fn bounds(&mut self, region: &Aabb) -> [Interval; N] {
        self.both.enter(region);
        let [first, second] = self.both.bounds();
        self.both.leave();
        let weight = match self.delay {
            None => Weights::<f64>::new(&self.transfer).second_bounds(first, second),
            Some(_) => Interval::new(0.0, 1.0),
        };
        self.mix.bounds(self.from.bounds(region), self.to.bounds(region), weight)
    }
}

/// Replaces the first distances by the second colour's weights.
#[multiversion::multiversion(targets = "simd")]
fn second_weights(weights: &Weights<f32>, per_unit: f32, first: &mut [f32], second: &[f32]) {
    for (first, second) in first.iter_mut().zip(second) {
        *first = weights.second(*first * per_unit, *second * per_unit);
    }
}

/// The same, each at a time of its own.
#[multiversion::multiversion(targets = "simd")]
fn second_weights_in_time(transfer: &Transfer, times: &[f32], per_unit: f32, first: &mut [f32], second: &[f32]) {
    for ((first, second), time) in first.iter_mut().zip(second).zip(times) {
        *first = Weights::at(transfer, *time).second(*first * per_unit, *second * per_unit);
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::attribute::{Constant, Straight};
    use crate::morph::exact::Exact;
    use crate::morph::{Moved, Similarity};

    fn weight(time: f64, alpha: f64, beta: f64, first: f64, second: f64) -> f64 {
        Transfer { time, alpha, beta }.weight(first, second)
    }

    fn places() -> impl Iterator<Item = (f64, f64)> {
        (-8..=8).flat_map(|one| (-8..=8).map(move |two| (f64::from(one) / 8.0, f64::from(two) / 8.0)))
    }

    fn parameters() -> impl Iterator<Item = (f64, f64)> {
        [0.01, 0.1, 0.3, 1.0, 3.0].into_iter().flat_map(|alpha| [0.0, 0.3, 0.5, 1.0].map(move |beta| (alpha, beta)))
    }

    #[test]
    fn gradients_are_the_differences_of_samples() {
        let turned = Similarity::new(2.0, DVec3::new(20.0, 30.0, 40.0), DVec3::X).expect("a placement");
        let constant = |value: f32| -> Arc<dyn Attribute<1>> {
            Arc::new(Moved::new(Arc::new(Constant::new([value])) as Arc<dyn Attribute<1>>, turned))
        };
        for (time, alpha, beta) in [(0.4, 0.3, 0.5), (0.7, 1.0, 0.3), (0.2, 0.1, 0.8)] {
            let attribute = MorphAttribute {
                first: Exact::ball(-0.4, 0.5),
                second: Exact::ball(0.5, 0.3),
                from: constant(1.0),
                to: constant(4.0),
                unit: 1.5,
                transfer: Transfer { time, alpha, beta },
                delay: None,
                mix: Straight,
            };
            let mut sampler = attribute.sampler();
            let mut points = Points::new(DVec3::new(0.05, 0.1, -0.1));
            let share = |i: usize, by: usize| (i * by % BATCH) as f32 / BATCH as f32 - 0.5;
            (0..BATCH).for_each(|i| points.push(Vec3::new(share(i, 37), share(i, 151), share(i, 263)) * 1.5));
            let (mut out, mut values) = ([Gradients::new()], [[0.0]; BATCH]);
            assert!(sampler.gradients(&points, &mut out));
            sampler.sample(&points, &mut values);
            let step = 1.0 / 1024.0;
            let mut slopes = [[0.0f32; BATCH]; 3];
            for (axis, slopes) in slopes.iter_mut().enumerate() {
                let [before, after] = [-step, step].map(|step| {
                    let (mut there, mut samples) = (points.clone(), [[0.0]; BATCH]);
                    there.origin += DVec3::AXES[axis] * step;
                    sampler.sample(&there, &mut samples);
                    samples
                });
                (0..BATCH).for_each(|i| slopes[i] = (after[i][0] - before[i][0]) / (2.0 * step as f32));
            }
            let mut steep = 0;
            for i in 0..BATCH {
                assert!((out[0].value[i] - values[i][0]).abs() < 1e-5);
                let exact = Vec3::new(slopes[0][i], slopes[1][i], slopes[2][i]);
                let found = out[0].gradient(i);
                assert!(
                    (found - exact).length() < 0.01 * (1.0 + exact.length()),
                    "{}: {found} {exact}",
                    points.position(i)
                );
                steep += usize::from(exact.length() > 0.5);
            }
            assert!(steep > 50, "{steep}");
        }
    }

    #[test]
    fn each_object_keeps_its_own_colour_at_its_end() {
        for (alpha, beta) in parameters() {
            for (first, second) in places() {
                if first >= 0.0 {
                    assert_eq!(weight(0.0, alpha, beta, first, second), 0.0);
                }
                if second >= 0.0 {
                    assert_eq!(weight(1.0, alpha, beta, first, second), 1.0);
                }
            }
        }
    }

    #[test]
    fn weights_are_shares_that_rise_with_time() {
        for (alpha, beta) in parameters() {
            for (first, second) in places() {
                let mut last = 0.0;
                for step in 0..=30 {
                    let now = weight(f64::from(step) / 20.0, alpha, beta, first, second);
                    assert!((0.0..=1.0).contains(&now) && now >= last - 1e-12, "{now} after {last}");
                    last = now;
                }
            }
        }
    }

    /// By the printed formula, with its plain root, outside both objects.
    #[test]
    fn weights_are_the_papers() {
        let and = |a: f64, b: f64| a + b - (a * a + b * b).sqrt();
        for (alpha, beta) in parameters() {
            for (first, second) in places().filter(|(first, second)| *first < 0.0 && *second < 0.0) {
                for time in [0.1, 0.5, 0.8] {
                    let g1 = and(first * 2.0 * (1.0 - beta), -alpha * time);
                    let g2 = and(second * 2.0 * beta, alpha * (time - 1.0));
                    assert!((weight(time, alpha, beta, first, second) - g1 / (g1 + g2)).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn a_small_alpha_goes_by_shape_and_a_large_one_by_time() {
        for (first, second) in places() {
            for time in [0.2, 0.5, 0.7] {
                assert!((weight(time, 1e4, 0.5, first, second) - time).abs() < 1e-3);
                if first < 0.0 && second < 0.0 {
                    let by_shape = first / (first + second);
                    assert!((weight(time, 1e-5, 0.5, first, second) - by_shape).abs() < 1e-3);
                }
            }
        }
        // Where both overlap and time does not count, nothing but time is left.
        assert_eq!(weight(0.4, 0.0, 0.5, 0.1, 0.2), 0.4);
    }

    /// Outside of the object at an end its colour gives way with the distance, from all of it on the surface.
    #[test]
    fn outside_at_the_ends_the_other_colour_comes_in_evenly() {
        for (alpha, beta) in parameters().filter(|(_, beta)| (0.1..0.9).contains(beta)) {
            for second in [-0.7, -0.2, 0.0, 0.4] {
                let mut last = 0.0;
                for far in [1e-9, 1e-3, 0.1, 0.5] {
                    let at_start = weight(0.0, alpha, beta, -far, second);
                    assert!(at_start > last && at_start < 1.0, "{at_start} after {last}");
                    // The second object stands as the first does, with β turned round.
                    let at_end = 1.0 - weight(1.0, alpha, 1.0 - beta, second, -far);
                    assert!((at_start - at_end).abs() < 1e-12);
                    last = at_start;
                }
                assert!(weight(0.0, alpha, beta, -1e-9, second) < 1e-6);
            }
        }
    }

    /// At its limits β leaves one of the distances out; in the middle both count alike.
    #[test]
    fn beta_at_its_limits_and_in_the_middle() {
        for alpha in [0.05, 0.3, 2.0] {
            for (first, second) in places() {
                for time in [0.1, 0.5, 0.9] {
                    assert_eq!(weight(time, alpha, 0.0, first, second), weight(time, alpha, 0.0, first, 0.3));
                    assert_eq!(weight(time, alpha, 1.0, first, second), weight(time, alpha, 1.0, 0.3, second));
                    let turned = weight(1.0 - time, alpha, 0.5, second, first);
                    assert!((weight(time, alpha, 0.5, first, second) + turned - 1.0).abs() < 1e-12);
                    // By time alone whatever β, where α is large.
                    let by_time = weight(time, 1e5, 0.2, first, second);
                    assert!((by_time - time).abs() < 1e-3, "{by_time} at {time}");
                }
            }
        }
    }

    #[test]
    fn beta_favours_an_object() {
        let at = |beta: f64| weight(0.5, 0.3, beta, -0.4, -0.4);
        assert!((at(0.5) - 0.5).abs() < 1e-12);
        assert!(at(0.0) > at(0.3) && at(0.3) > at(0.5) && at(0.5) > at(0.8) && at(0.8) > at(1.0));
    }

    /// Past the end the second object's colour creeps outward, and outside it never takes over in full.
    #[test]
    fn the_octopus_creeps_outward() {
        let at = |time: f64, second: f64| weight(time, 0.3, 0.5, -0.2, second);
        for second in [-0.05, -0.2, -0.5] {
            assert!(at(1.0, second) < at(1.3, second) && at(1.3, second) < at(3.0, second) && at(3.0, second) < 1.0);
        }
        assert_eq!(at(1.7, 0.1), 1.0);
        assert!(at(1.3, -0.05) > at(1.3, -0.2));
    }
}
