//! The colour of a union of coloured parts, and of a blend.

use std::sync::Arc;

use super::{Colour, ColourSampler, LinearRgb};
use crate::field::{Aabb, BATCH, Evaluator, Field, Points};

/// A solid with its colour. Distances, or fields that are nearly so: their values are compared between parts.
pub type Part = (Arc<dyn Field>, Arc<dyn Colour>);

/// What decides between the parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// Inside a part its own colour, the later part's in an overlap, over `seam` world units of transition where parts
    /// meet (0: a sharp edge); outside all parts by the inverse of the distances (STTI, eq. 6).
    Union {
        /// The width of the transition.
        seam: f64,
    },
    /// By the inverse of the distances, inside and outside: on a part's surface its own colour, between parts all.
    Blend,
}

/// Several coloured parts as one colour. All weights are convex: parts of one colour give that colour.
///
/// The field of a difference or an intersection keeps its first operand's colour and needs nothing of this.
pub struct Parts {
    parts: Vec<Part>,
    rule: Rule,
    tolerance: f32,
}

impl Parts {
    /// The colour of these parts, the later above the earlier. Points no further outside than `tolerance`, world units,
    /// are inside: those on a surface are a rounding error off to either side. `None` where there are no parts.
    pub fn new(parts: Vec<Part>, rule: Rule, tolerance: f64) -> Option<Self> {
        (!parts.is_empty()).then_some(Self { parts, rule, tolerance: tolerance as f32 })
    }

    fn weigh(&self, distances: &[[f32; BATCH]], weights: &mut [[f32; BATCH]], len: usize) {
        match self.rule {
            Rule::Blend => inverse_distances(distances, weights, len),
            Rule::Union { seam } if seam > 0.0 => {
                inverse_distances(distances, weights, len);
                soft_union(distances, weights, len, seam as f32, self.tolerance);
            }
            Rule::Union { .. } => {
                inverse_distances(distances, weights, len);
                sharp_union(distances, weights, len, self.tolerance);
            }
        }
    }
}

/// 1/|f_j| over their sum; the later part alone where several are 0.
fn inverse_distances(distances: &[[f32; BATCH]], weights: &mut [[f32; BATCH]], len: usize) {
    for i in 0..len {
        let nearest = distances.iter().fold(f32::INFINITY, |least, distance| least.min(distance[i].abs()));
        if nearest < f32::MIN_POSITIVE {
            let touched = distances.iter().rposition(|distance| distance[i].abs() == nearest);
            weights
                .iter_mut()
                .enumerate()
                .for_each(|(part, weight)| weight[i] = f32::from(u8::from(touched == Some(part))));
            continue;
        }
        let mut sum = 0.0;
        for (weight, distance) in weights.iter_mut().zip(distances) {
            weight[i] = nearest / distance[i].abs();
            sum += weight[i];
        }
        weights.iter_mut().for_each(|weight| weight[i] /= sum);
    }
}

/// The last part that holds the point takes it all.
fn sharp_union(distances: &[[f32; BATCH]], weights: &mut [[f32; BATCH]], len: usize, tolerance: f32) {
    for i in 0..len {
        if let Some(inside) = distances.iter().rposition(|distance| distance[i] >= -tolerance) {
            weights.iter_mut().enumerate().for_each(|(part, weight)| weight[i] = f32::from(u8::from(part == inside)));
        }
    }
}

/// Parts painted over one another with edges `seam` wide, their middle on the surface. What is painted counts by its
/// own weights as soon as the point is inside a part; on the way out the weights there go over into those outside.
fn soft_union(distances: &[[f32; BATCH]], weights: &mut [[f32; BATCH]], len: usize, seam: f32, tolerance: f32) {
    for i in 0..len {
        let cover = |distance: &[f32; BATCH]| (0.5 + (distance[i] + tolerance) / seam).clamp(0.0, 1.0);
        let bare = distances.iter().fold(1.0, |bare, distance| bare * (1.0 - cover(distance)));
        let painted = 1.0 - bare;
        if painted <= 0.0 {
            continue;
        }
        let share = (2.0 * painted).min(1.0);
        let mut above = 1.0;
        for (weight, distance) in weights.iter_mut().zip(distances).rev() {
            let own = cover(distance) * above;
            above *= 1.0 - cover(distance);
            weight[i] += (own / painted - weight[i]) * share;
        }
    }
}

impl Colour for Parts {
    fn sampler(&self) -> Box<dyn ColourSampler + '_> {
        Box::new(PartsSampler {
            parts: self,
            evaluators: self.parts.iter().map(|(field, _)| field.evaluator()).collect(),
            samplers: self.parts.iter().map(|(_, colour)| colour.sampler()).collect(),
            distances: vec![[0.0; BATCH]; self.parts.len()],
            weights: vec![[0.0; BATCH]; self.parts.len()],
            colours: [[0.0; 3]; BATCH],
        })
    }
}

struct PartsSampler<'a> {
    parts: &'a Parts,
    evaluators: Vec<Box<dyn Evaluator + 'a>>,
    samplers: Vec<Box<dyn ColourSampler + 'a>>,
    distances: Vec<[f32; BATCH]>,
    weights: Vec<[f32; BATCH]>,
    colours: [LinearRgb; BATCH],
}

impl ColourSampler for PartsSampler<'_> {
    // The fields enter no region: pruning keeps their zero sets, but here their values count.
    fn enter(&mut self, region: &Aabb) {
        self.samplers.iter_mut().for_each(|sampler| sampler.enter(region));
    }

    fn leave(&mut self) {
        self.samplers.iter_mut().for_each(|sampler| sampler.leave());
    }

    fn sample(&mut self, points: &Points, out: &mut [LinearRgb; BATCH]) {
        for (evaluator, distances) in self.evaluators.iter_mut().zip(&mut self.distances) {
            evaluator.values(points, distances);
        }
        self.parts.weigh(&self.distances, &mut self.weights, points.len);
        out[..points.len].fill([0.0; 3]);
        for (sampler, weights) in self.samplers.iter_mut().zip(&self.weights) {
            if weights[..points.len].iter().all(|weight| *weight == 0.0) {
                continue;
            }
            sampler.sample(points, &mut self.colours);
            for ((out, colour), weight) in out.iter_mut().zip(&self.colours).zip(weights).take(points.len) {
                if *weight > 0.0 {
                    out.iter_mut().zip(colour).for_each(|(sum, part)| *sum += weight * part);
                }
            }
        }
    }
}
