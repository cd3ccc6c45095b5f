//! Values of features that go over into one another along the inside of a body.

use std::sync::Arc;

use super::feature::Feature;
use super::lookup::Lookup;
use super::nodes::Body;
use super::outside::Outside;
use super::weights::{Zones, nearest};
use crate::attribute::{Attribute, Mix, Sampler};
use crate::field::{Aabb, BATCH, Evaluator, Interval, Points};

/// A feature with its attribute.
pub type Member<const N: usize> = (Arc<Feature>, Arc<dyn Attribute<N>>);

/// The attributes of features by their weights (CONFORMAL, eq. 10), mixed one after the other.
pub struct Conformal<const N: usize, M> {
    /// The body.
    pub body: Arc<Body>,
    /// The features, at least one.
    pub members: Vec<Member<N>>,
    /// Where they go over into one another.
    pub zones: Zones,
    /// How all before each feature but the first are mixed with it: one fewer than members.
    pub mixes: Vec<M>,
    outside: Option<Outside>,
}

impl<const N: usize, M> Conformal<N, M> {
    /// With one fewer mix than there are members. Outside of the body weights are those of the nearest place of its surface.
    pub fn new(body: Arc<Body>, members: Vec<Member<N>>, zones: Zones, mixes: Vec<M>) -> Self {
        Self { body, members, zones, mixes, outside: None }
    }

    /// The same with weights that do not jump outside of the body.
    pub fn smooth(mut self) -> Self {
        let (body, count) = (&self.body, self.zones.count());
        let sampler = || {
            let mut distances = Distances::new(body, self.members.iter().map(|(feature, _)| feature.as_ref()));
            let mut weights = vec![0.0; count];
            let zones = &self.zones;
            move |points: &Points, out: &mut [f32]| {
                distances.find(points);
                for (i, out) in out.chunks_exact_mut(count).enumerate() {
                    zones.weigh(distances.of(i), &mut weights);
                    out.iter_mut().zip(&weights).for_each(|(out, weight)| *out = *weight as f32);
                }
            }
        };
        self.outside = Some(Outside::new(body, count, sampler));
        self
    }
}

/// The number of the nearest feature, from 0.
pub struct Nearest {
    /// The body.
    pub body: Arc<Body>,
    /// The features, at least one.
    pub features: Vec<Arc<Feature>>,
}

/// The interior distances of some features, on one thread.
struct Distances<'a> {
    lookup: Lookup<'a>,
    features: Vec<(&'a Feature, Box<dyn Evaluator + 'a>)>,
    /// Of each feature, in cells.
    values: Vec<[f32; BATCH]>,
    /// Of one point.
    of_point: Vec<f32>,
}

impl<'a> Distances<'a> {
    fn new(body: &'a Body, features: impl Iterator<Item = &'a Feature>) -> Self {
        let features: Vec<_> = features.map(|feature| (feature, feature.field().evaluator())).collect();
        let count = features.len();
        Self { lookup: Lookup::new(body), features, values: vec![[0.0; BATCH]; count], of_point: vec![0.0; count] }
    }

    fn find(&mut self, points: &Points) {
        self.lookup.begin(points);
        for ((feature, evaluator), values) in self.features.iter_mut().zip(&mut self.values) {
            self.lookup.distances(feature, evaluator.as_mut(), values);
        }
    }

    /// Those of one point of the batch.
    fn of(&mut self, i: usize) -> &[f32] {
        for (distance, values) in self.of_point.iter_mut().zip(&self.values) {
            *distance = values[i];
        }
        &self.of_point
    }
}

impl<const N: usize, M: Mix<N>> Attribute<N> for Conformal<N, M> {
    fn sampler(&self) -> Box<dyn Sampler<N> + '_> {
        let count = self.zones.count();
        Box::new(ConformalSampler {
            conformal: self,
            distances: Distances::new(&self.body, self.members.iter().map(|(feature, _)| feature.as_ref())),
            samplers: self.members.iter().map(|(_, attribute)| attribute.sampler()).collect(),
            of_point: vec![0.0; count],
            mixed: vec![0.0; count],
            weights: vec![[0.0; BATCH]; count],
            sums: [0.0; BATCH],
            shares: [0.0; BATCH],
            values: [[0.0; N]; BATCH],
        })
    }
}

struct ConformalSampler<'a, const N: usize, M> {
    conformal: &'a Conformal<N, M>,
    distances: Distances<'a>,
    samplers: Vec<Box<dyn Sampler<N> + 'a>>,
    of_point: Vec<f64>,
    mixed: Vec<f32>,
    weights: Vec<[f32; BATCH]>,
    sums: [f32; BATCH],
    shares: [f32; BATCH],
    values: [[f32; N]; BATCH],
}

impl<const N: usize, M: Mix<N>> ConformalSampler<'_, N, M> {
    fn weigh(&mut self, points: &Points) {
        self.distances.find(points);
        for i in 0..points.len {
            self.conformal.zones.weigh(self.distances.of(i), &mut self.of_point);
            self.mixed.iter_mut().zip(&self.of_point).for_each(|(mixed, weight)| *mixed = *weight as f32);
            let away = self.distances.lookup.away(i);
            if let Some(outside) = self.conformal.outside.as_ref().filter(|_| away > 0.0) {
                outside.mix(points.position(i), away, &mut self.mixed);
            }
            for (weights, weight) in self.weights.iter_mut().zip(&self.mixed) {
                weights[i] = *weight;
            }
        }
    }
}

impl<const N: usize, M: Mix<N>> Sampler<N> for ConformalSampler<'_, N, M> {
    // No region is entered: points outside are looked up elsewhere.
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [[f32; N]; BATCH]) {
        self.weigh(points);
        let len = points.len;
        self.sums[..len].fill(0.0);
        for (k, sampler) in self.samplers.iter_mut().enumerate() {
            let weights = &self.weights[k][..len];
            if k > 0 && weights.iter().all(|weight| *weight == 0.0) {
                continue;
            }
            // Places that jump are none for what is not to jump.
            let at = if self.conformal.outside.is_some() { points } else { self.distances.lookup.points() };
            sampler.sample(at, &mut self.values);
            if k == 0 {
                out[..len].copy_from_slice(&self.values[..len]);
                self.sums[..len].copy_from_slice(weights);
                continue;
            }
            // What came before counts as one, by the sum of its weights.
            for i in 0..len {
                self.sums[i] += weights[i];
                self.shares[i] = if weights[i] > 0.0 { weights[i] / self.sums[i] } else { 0.0 };
            }
            self.conformal.mixes[k - 1].mix_batch(out, &self.values, &self.shares, len);
        }
    }

    /// Straight mixes lie between the features' values.
    fn bounds(&mut self, region: &Aabb) -> [Interval; N] {
        if !self.conformal.mixes.iter().all(Mix::is_straight) {
            return [Interval::ALL; N];
        }
        // Points outside of the body are looked up at its surface, anywhere.
        let anywhere = self.conformal.body.aabb().union(*region);
        let all = self.samplers.iter_mut().map(|sampler| sampler.bounds(&anywhere));
        let both = |a: [Interval; N], b: [Interval; N]| std::array::from_fn(|i| a[i].union(b[i]));
        all.reduce(both).unwrap_or([Interval::ALL; N])
    }
}

impl Attribute<1> for Nearest {
    fn sampler(&self) -> Box<dyn Sampler<1> + '_> {
        let features = self.features.iter().map(Arc::as_ref);
        Box::new(NearestSampler { distances: Distances::new(&self.body, features) })
    }
}

struct NearestSampler<'a> {
    distances: Distances<'a>,
}

impl Sampler<1> for NearestSampler<'_> {
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [[f32; 1]; BATCH]) {
        self.distances.find(points);
        for i in 0..points.len {
            out[i] = [nearest(self.distances.of(i)) as f32];
        }
    }

    fn bounds(&mut self, _region: &Aabb) -> [Interval; 1] {
        [Interval::new(0.0, (self.distances.values.len() - 1) as f64)]
    }
}
