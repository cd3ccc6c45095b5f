//! Space-time transfinite interpolation: how much of each object's colour a point has, and the mixed colour of a frame.

use std::sync::Arc;

use super::real::{Real, intersection};
use crate::attribute::{Colour, ColourSampler, LinearRgb, Mixer};
use crate::distance::Distance;
use crate::field::{Aabb, BATCH, Evaluator, Points};

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
        let Transfer { time, alpha, beta } = *transfer;
        Self {
            first_scale: T::of(2.0 * (1.0 - beta)),
            first_cut: T::of(-alpha * time),
            second_scale: T::of(2.0 * beta),
            second_cut: T::of(alpha * time - alpha),
            level: T::of(time.clamp(0.0, 1.0)),
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

impl Transfer {
    /// The second colour's weight in \[0, 1\] where the objects' signed distances are these, in units of D.
    pub fn weight(&self, first: f64, second: f64) -> f64 {
        Weights::<f64>::new(self).second(first, second)
    }
}

/// A frame's colour: both objects' colours at the point itself, mixed by [`Transfer`]. Distances and colours stand in
/// the world as they do at this instant.
pub struct MorphColour {
    /// The first object.
    pub first: Arc<dyn Distance>,
    /// The second object.
    pub second: Arc<dyn Distance>,
    /// The first object's colour.
    pub from: Arc<dyn Colour>,
    /// The second object's colour.
    pub to: Arc<dyn Colour>,
    /// D, world units.
    pub unit: f64,
    /// The weights.
    pub transfer: Transfer,
    /// The mixing.
    pub mixer: Mixer,
}

impl Colour for MorphColour {
    fn sampler(&self) -> Box<dyn ColourSampler + '_> {
        Box::new(MorphSampler {
            mixer: self.mixer,
            weights: Weights::new(&self.transfer),
            per_unit: (1.0 / self.unit) as f32,
            first: self.first.evaluator(),
            second: self.second.evaluator(),
            from: self.from.sampler(),
            to: self.to.sampler(),
            distances: [[0.0; BATCH]; 2],
            colours: [[0.0; 3]; BATCH],
        })
    }
}

struct MorphSampler<'a> {
    mixer: Mixer,
    weights: Weights<f32>,
    per_unit: f32,
    first: Box<dyn Evaluator + 'a>,
    second: Box<dyn Evaluator + 'a>,
    from: Box<dyn ColourSampler + 'a>,
    to: Box<dyn ColourSampler + 'a>,
    distances: [[f32; BATCH]; 2],
    colours: [LinearRgb; BATCH],
}

impl ColourSampler for MorphSampler<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.first.enter(region);
        self.second.enter(region);
        self.from.enter(region);
        self.to.enter(region);
    }

    fn leave(&mut self) {
        self.first.leave();
        self.second.leave();
        self.from.leave();
        self.to.leave();
    }

    fn sample(&mut self, points: &Points, out: &mut [LinearRgb; BATCH]) {
        let [first, second] = &mut self.distances;
        self.first.values(points, first);
        self.second.values(points, second);
        second_weights(&self.weights, self.per_unit, &mut first[..points.len], &second[..points.len]);
        let weights = first;
        self.from.sample(points, out);
        self.to.sample(points, &mut self.colours);
        self.mixer.mix_batch(out, &self.colours, weights, points.len);
    }
}

/// Replaces the first distances by the second colour's weights.
#[multiversion::multiversion(targets = "simd")]
fn second_weights(weights: &Weights<f32>, per_unit: f32, first: &mut [f32], second: &[f32]) {
    for (first, second) in first.iter_mut().zip(second) {
        *first = weights.second(*first * per_unit, *second * per_unit);
    }
}
