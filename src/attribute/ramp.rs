//! Values by a number: stops, and something between each and the next.

use std::sync::Arc;

use super::{Attribute, Mix, Sampler};
use crate::field::{Aabb, BATCH, Evaluator, Field, Interval, Points};

/// How a value becomes the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RampEase {
    /// Evenly.
    Linear,
    /// From rest to rest.
    Smooth,
    /// At once, where the next stop is.
    Hold,
}

impl RampEase {
    fn eased(self, share: f32) -> f32 {
        match self {
            Self::Linear => share,
            Self::Smooth => share * share * (3.0 - 2.0 * share),
            Self::Hold => 0.0,
        }
    }
}

/// Values at stops of a number; the first and the last hold beyond.
pub struct Ramp<const N: usize, M> {
    /// The number; one that keeps its values.
    pub by: Arc<dyn Field>,
    /// Where each value is, rising; at least one.
    pub stops: Vec<(f64, [f32; N])>,
    /// How each value and the next are mixed: one fewer than stops.
    pub mixes: Vec<M>,
    /// How a value becomes the next.
    pub ease: RampEase,
}

impl<const N: usize, M: Mix<N>> Ramp<N, M> {
    fn at(&self, number: f32) -> [f32; N] {
        if number.is_nan() {
            return [f32::NAN; N];
        }
        let next = self.stops.partition_point(|(at, _)| *at as f32 <= number);
        match next {
            0 => self.stops[0].1,
            _ if next == self.stops.len() => self.stops[next - 1].1,
            _ => {
                let ((from, first), (to, second)) = (self.stops[next - 1], self.stops[next]);
                let share = ((f64::from(number) - from) / (to - from)).clamp(0.0, 1.0) as f32;
                self.mixes[next - 1].mix(first, second, self.ease.eased(share))
            }
        }
    }
}

impl<const N: usize, M: Mix<N> + 'static> Attribute<N> for Ramp<N, M> {
    fn sampler(&self) -> Box<dyn Sampler<N> + '_> {
        Box::new(RampSampler { ramp: self, by: self.by.evaluator(), numbers: [0.0; BATCH] })
    }
}

struct RampSampler<'a, const N: usize, M> {
    ramp: &'a Ramp<N, M>,
    by: Box<dyn Evaluator + 'a>,
    numbers: [f32; BATCH],
}

impl<const N: usize, M: Mix<N>> Sampler<N> for RampSampler<'_, N, M> {
    // The field enters no region: its values count, not its zero set.
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [[f32; N]; BATCH]) {
        self.by.values(points, &mut self.numbers);
        for (out, number) in out.iter_mut().zip(self.numbers).take(points.len) {
            *out = self.ramp.at(number);
        }
    }

    /// Of straight mixes: between two stops the extremes are at ends.
    fn bounds(&mut self, region: &Aabb) -> [Interval; N] {
        let Ramp { stops, mixes, .. } = self.ramp;
        if !mixes.iter().all(Mix::is_straight) {
            return [Interval::ALL; N];
        }
        self.by.enter(region);
        let Interval { lo, hi } = self.by.bounds();
        self.by.leave();
        // Rounding of the number's ends to a float may pass a stop.
        let (lo, hi) = ((lo as f32).next_down(), (hi as f32).next_up());
        let within = stops.iter().filter(|(at, _)| (lo..=hi).contains(&(*at as f32))).map(|(_, value)| *value);
        let held = stops.iter().rev().find(|(at, _)| *at as f32 <= lo).map(|(_, value)| *value);
        let slack = |value: f32| f64::from(value.abs()) * 4.0 * f64::from(f32::EPSILON);
        let ends = [self.ramp.at(lo), self.ramp.at(hi)].into_iter().chain(within);
        let ends: Vec<[f32; N]> =
            if self.ramp.ease == RampEase::Hold { ends.chain(held).collect() } else { ends.collect() };
        std::array::from_fn(|i| {
            let single = |value: &[f32; N]| {
                Interval::new(f64::from(value[i]) - slack(value[i]), f64::from(value[i]) + slack(value[i]))
            };
            ends.iter().map(single).reduce(Interval::union).unwrap_or(Interval::ALL)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attribute::Straight;
    use crate::field::tests::Samples;
    use crate::field::{Expression, Graph};
    use glam::DVec3;

    fn ramp(ease: RampEase) -> Ramp<1, Straight> {
        let mut graph = Graph::new();
        let x = graph.x();
        let by = Arc::new(Expression::new(&graph, x).keeping_values());
        Ramp { by, stops: vec![(-1.0, [2.0]), (0.0, [4.0]), (2.0, [0.0])], mixes: vec![Straight; 2], ease }
    }

    #[test]
    fn between_stops_values_are_mixed() {
        let linear = ramp(RampEase::Linear);
        assert_eq!(
            [-9.0, -1.0, -0.5, 0.0, 1.0, 1.5, 2.0, 7.0].map(|x| linear.at(x)[0]),
            [2.0, 2.0, 3.0, 4.0, 2.0, 1.0, 0.0, 0.0]
        );
        assert_eq!([-0.75, 0.5].map(|x| ramp(RampEase::Smooth).at(x)[0]), [2.3125, 3.375]);
        assert_eq!([-2.0, -0.01, 0.0, 1.99, 2.0].map(|x| ramp(RampEase::Hold).at(x)[0]), [2.0, 2.0, 4.0, 4.0, 0.0]);
        assert!(linear.at(f32::NAN)[0].is_nan());
    }

    #[test]
    fn bounds_hold_all_values() {
        for ease in [RampEase::Linear, RampEase::Smooth, RampEase::Hold] {
            let ramp = ramp(ease);
            let (mut sampler, mut samples) = (ramp.sampler(), Samples::new(1));
            for _ in 0..300 {
                let size = 3.0 * samples.next();
                let min = samples.within(&Aabb::new(DVec3::splat(-3.0), DVec3::splat(3.0)));
                let region = Aabb::new(min, min + size);
                let [bounds] = sampler.bounds(&region);
                for _ in 0..20 {
                    let value = ramp.at(samples.within(&region).x as f32)[0];
                    assert!(bounds.contains(value.into()), "{value} is not in {bounds:?}");
                }
            }
        }
    }
}
