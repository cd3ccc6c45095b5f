//! The interior distance as a scalar.

use std::sync::Arc;

use super::feature::Feature;
use super::lookup::Lookup;
use super::nodes::Body;
use super::outside::Outside;
use crate::attribute::{Attribute, Sampler};
use crate::field::{Aabb, BATCH, Evaluator, Interval, Points};

/// What an interior distance leads to.
#[derive(Clone)]
pub enum Goal {
    /// A feature.
    Feature(Arc<Feature>),
    /// The body's own surface: the depth.
    Surface,
}

/// The length of the shortest way inside of a body to the nearest of some goals, units: 0 in them, nowhere negative. Outside
/// of the body that of the nearest place of its surface, or what does not jump between such.
pub struct Interior {
    body: Arc<Body>,
    goals: Vec<Goal>,
    outside: Option<Outside>,
}

impl Interior {
    /// To at least one goal.
    pub fn new(body: Arc<Body>, goals: Vec<Goal>) -> Self {
        Self { body, goals, outside: None }
    }

    /// The same without jumps outside of the body.
    pub fn smooth(mut self) -> Self {
        let sampler = || {
            let (mut sampler, mut out) = (self.sampler(), [[0.0]; BATCH]);
            move |points: &Points, values: &mut [f32]| {
                sampler.sample(points, &mut out);
                values.iter_mut().zip(&out).for_each(|(value, [out])| *value = *out);
            }
        };
        self.outside = Some(Outside::new(&self.body, 1, sampler));
        self
    }
}

impl Attribute<1> for Interior {
    fn sampler(&self) -> Box<dyn Sampler<1> + '_> {
        let evaluators = self
            .goals
            .iter()
            .map(|goal| match goal {
                Goal::Feature(feature) => feature.field().evaluator(),
                Goal::Surface => self.body.distance().evaluator(),
            })
            .collect();
        Box::new(InteriorSampler {
            interior: self,
            lookup: Lookup::new(&self.body),
            evaluators,
            values: [0.0; BATCH],
            greatest: None,
        })
    }
}

struct InteriorSampler<'a> {
    interior: &'a Interior,
    lookup: Lookup<'a>,
    evaluators: Vec<Box<dyn Evaluator + 'a>>,
    values: [f32; BATCH],
    /// The greatest value, units, once it is asked for.
    greatest: Option<f64>,
}

impl InteriorSampler<'_> {
    fn greatest(&self) -> f64 {
        let Interior { body, goals, .. } = self.interior;
        /// A place is no further from a node around it than the diagonal of a cell and a node's own way from its middle.
        const BESIDE: f32 = 3.0;
        let of_goal = |goal: &Goal| match goal {
            Goal::Feature(feature) => feature.greatest(BESIDE),
            Goal::Surface => (0..body.len() as u32).fold(0.0, |deepest, node| body.depth(node).max(deepest)) + BESIDE,
        };
        let least = goals.iter().map(of_goal).fold(f32::INFINITY, f32::min);
        f64::from(least) * body.edge()
    }
}

impl Sampler<1> for InteriorSampler<'_> {
    // No region is entered: points outside are looked up elsewhere.
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [[f32; 1]; BATCH]) {
        let Interior { body, goals, outside } = self.interior;
        self.lookup.begin(points);
        out[..points.len].fill([f32::INFINITY]);
        let edge = body.edge() as f32;
        for (goal, evaluator) in goals.iter().zip(&mut self.evaluators) {
            let scale = match goal {
                Goal::Feature(feature) => {
                    self.lookup.distances(feature, evaluator.as_mut(), &mut self.values);
                    edge
                }
                Goal::Surface => {
                    evaluator.values(self.lookup.points(), &mut self.values);
                    self.values[..points.len]
                        .iter_mut()
                        .for_each(|depth| *depth = if *depth < 0.0 { 0.0 } else { *depth });
                    1.0
                }
            };
            for (out, value) in out.iter_mut().zip(&self.values).take(points.len) {
                let value = value * scale;
                // What is not a number stays so, and is told.
                out[0] = if value < out[0] || value.is_nan() { value } else { out[0] };
            }
        }
        if let Some(outside) = outside {
            for i in (0..points.len).filter(|i| self.lookup.away(*i) > 0.0) {
                outside.mix(points.position(i), self.lookup.away(i), &mut out[i]);
            }
        }
    }

    fn bounds(&mut self, _region: &Aabb) -> [Interval; 1] {
        let greatest = match self.greatest {
            Some(known) => known,
            None => *self.greatest.insert(self.greatest()),
        };
        [Interval::new(0.0, greatest)]
    }
}
