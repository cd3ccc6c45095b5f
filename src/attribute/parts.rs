//! An attribute of a union of parts that have it, and of a blend.

use std::hint::select_unpredictable;
use std::sync::Arc;

use multiversion::multiversion;

use super::{Attribute, Sampler};
use crate::field::lane_math::clamp01;
use crate::field::{Aabb, BATCH, Evaluator, Field, Interval, Points};

/// A solid with its attribute. Distances, or fields that are nearly so: their values are compared between parts, so they
/// must stay what they are in a region entered.
pub type Part<const N: usize> = (Arc<dyn Field>, Arc<dyn Attribute<N>>);

/// What decides between the parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// Inside a part its own value, the later part's in an overlap, over `seam` world units of transition where parts
    /// meet (0: a sharp edge); outside all parts by the inverse of the distances (STTI, eq. 6).
    Union {
        /// The width of the transition.
        seam: f64,
    },
    /// By the inverse of the distances, inside and outside: on a part's surface its own value, between parts all.
    Blend,
    /// As the partitions of a morph (STTI, section 4.2.2): inside a partition its own value, outside all that of the
    /// master, or where there is none of the nearest.
    Partitions {
        /// What holds inside several.
        overlap: Overlap,
        /// The place of the one that holds outside all.
        master: Option<usize>,
    },
}

/// What a point inside several partitions has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlap {
    /// The value of the last of them (STTI, eq. 8).
    Priority,
    /// The mean of all their values (STTI, eq. 9).
    Mix,
}

/// Several parts' values as one. All weights are convex: parts of one value give that value.
///
/// The field of a difference or an intersection keeps its first operand's attributes and needs nothing of this.
pub struct Parts<const N: usize> {
    parts: Vec<Part<N>>,
    rule: Rule,
    tolerance: f32,
}

impl<const N: usize> Parts<N> {
    /// The attribute of these parts, the later above the earlier. Points no further outside than `tolerance`, world units,
    /// are inside: those on a surface are a rounding error off to either side. `None` where there are no parts.
    pub fn new(parts: Vec<Part<N>>, rule: Rule, tolerance: f64) -> Option<Self> {
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
            Rule::Partitions { overlap, master } => {
                match master {
                    None => nearest(distances, weights, len),
                    Some(master) => {
                        weights.iter_mut().for_each(|weight| weight[..len].fill(0.0));
                        weights[master][..len].fill(1.0);
                    }
                }
                match overlap {
                    Overlap::Priority => sharp_union(distances, weights, len, self.tolerance),
                    Overlap::Mix => even_union(distances, weights, len, self.tolerance),
                }
            }
        }
    }
}

/// So many points at a time, whose least and last so far stay in registers: what is chosen in memory, or else kept, becomes
/// a masked store (see `lane_math`).
const LANES: usize = 16;

#[inline(always)]
fn row(values: &[f32; BATCH], at: usize) -> &[f32; LANES] {
    &values.as_chunks().0[at]
}

#[inline(always)]
fn row_mut(values: &mut [f32; BATCH], at: usize) -> &mut [f32; LANES] {
    &mut values.as_chunks_mut().0[at]
}

/// 1/|f_j| over their sum; the later part alone where several are 0.
#[multiversion(targets = "simd")]
fn inverse_distances(distances: &[[f32; BATCH]], weights: &mut [[f32; BATCH]], len: usize) {
    for at in 0..len.min(BATCH).div_ceil(LANES) {
        let (mut nearest, mut touched, mut sum) = ([f32::INFINITY; LANES], [0; LANES], [0.0; LANES]);
        for (part, distances) in (0u32..).zip(distances) {
            let distances = row(distances, at);
            for i in 0..LANES {
                let near = distances[i].abs();
                touched[i] = select_unpredictable(near <= nearest[i], part, touched[i]);
                nearest[i] = if near < nearest[i] { near } else { nearest[i] };
            }
        }
        for ((part, distances), weights) in (0u32..).zip(distances).zip(&mut *weights) {
            let (distances, weights) = (row(distances, at), row_mut(weights, at));
            for i in 0..LANES {
                let alone = if touched[i] == part { 1.0 } else { 0.0 };
                let share = nearest[i] / distances[i].abs();
                weights[i] = select_unpredictable(nearest[i] < f32::MIN_POSITIVE, alone, share);
                sum[i] += weights[i];
            }
        }
        for weights in &mut *weights {
            let weights = row_mut(weights, at);
            for i in 0..LANES {
                weights[i] /= sum[i];
            }
        }
    }
}

/// The part whose distance is greatest takes it all, the later of two.
#[multiversion(targets = "simd")]
fn nearest(distances: &[[f32; BATCH]], weights: &mut [[f32; BATCH]], len: usize) {
    for at in 0..len.min(BATCH).div_ceil(LANES) {
        let (mut greatest, mut nearest) = ([f32::NEG_INFINITY; LANES], [0; LANES]);
        for (part, distances) in (0u32..).zip(distances) {
            let distances = row(distances, at);
            for i in 0..LANES {
                nearest[i] = select_unpredictable(distances[i] >= greatest[i], part, nearest[i]);
                greatest[i] = if distances[i] > greatest[i] { distances[i] } else { greatest[i] };
            }
        }
        for (part, weights) in (0u32..).zip(&mut *weights) {
            let weights = row_mut(weights, at);
            for i in 0..LANES {
                weights[i] = if nearest[i] == part { 1.0 } else { 0.0 };
            }
        }
    }
}

/// The last part that holds the point takes it all.
#[multiversion(targets = "simd")]
fn sharp_union(distances: &[[f32; BATCH]], weights: &mut [[f32; BATCH]], len: usize, tolerance: f32) {
    let len = len.min(BATCH);
    // By maxima and sums: a choice between a new value and the old one becomes a masked store (see `lane_math`).
    const NONE: i32 = -1;
    let mut inside = [NONE; BATCH];
    for (part, distance) in (0i32..).zip(distances) {
        for i in 0..len {
            inside[i] = inside[i].max(if distance[i] >= -tolerance { part } else { NONE });
        }
    }
    for (part, weight) in (0i32..).zip(weights) {
        for i in 0..len {
            let kept = if inside[i] == NONE { weight[i] } else { 0.0 };
            let own = if inside[i] == part { 1.0 } else { 0.0 };
            weight[i] = kept + own;
        }
    }
}

/// All parts that hold the point share it evenly.
#[multiversion(targets = "simd")]
fn even_union(distances: &[[f32; BATCH]], weights: &mut [[f32; BATCH]], len: usize, tolerance: f32) {
    let len = len.min(BATCH);
    let mut holding = [0.0; BATCH];
    for distance in distances {
        for i in 0..len {
            holding[i] += if distance[i] >= -tolerance { 1.0 } else { 0.0 };
        }
    }
    for (distance, weight) in distances.iter().zip(weights) {
        for i in 0..len {
            let share = if distance[i] >= -tolerance { 1.0 / holding[i] } else { 0.0 };
            weight[i] = if holding[i] > 0.0 { share } else { weight[i] };
        }
    }
}

/// Parts painted over one another with edges `seam` wide, their middle on the surface. What is painted counts by its
/// own weights as soon as the point is inside a part; on the way out the weights there go over into those outside.
#[multiversion(targets = "simd")]
fn soft_union(distances: &[[f32; BATCH]], weights: &mut [[f32; BATCH]], len: usize, seam: f32, tolerance: f32) {
    let len = len.min(BATCH);
    let cover = |distance: f32| clamp01(0.5 + (distance + tolerance) / seam);
    let (mut bare, mut above) = ([1.0; BATCH], [1.0; BATCH]);
    for distance in distances {
        for i in 0..len {
            bare[i] *= 1.0 - cover(distance[i]);
        }
    }
    for (weight, distance) in weights.iter_mut().zip(distances).rev() {
        for i in 0..len {
            let painted = 1.0 - bare[i];
            let share = if 2.0 * painted < 1.0 { 2.0 * painted } else { 1.0 };
            let cover = cover(distance[i]);
            let own = cover * above[i];
            above[i] *= 1.0 - cover;
            let shared = (own / painted - weight[i]) * share;
            weight[i] += select_unpredictable(painted > 0.0, shared, 0.0);
        }
    }
}

/// Adds a part's values by their weights, and keeps the greatest of each number.
#[multiversion(targets = "simd")]
fn add<const N: usize>(
    values: &[[f32; N]; BATCH],
    weights: &[f32; BATCH],
    len: usize,
    out: &mut [[f32; N]; BATCH],
    greatest: &mut [[f32; N]; BATCH],
) {
    let (out, greatest) = (out.as_chunks_mut::<LANES>().0, greatest.as_chunks_mut::<LANES>().0);
    let rows = out.iter_mut().zip(greatest).zip(values.as_chunks::<LANES>().0);
    for (((out, greatest), values), weights) in rows.zip(weights.as_chunks::<LANES>().0).take(len.div_ceil(LANES)) {
        // A weight for each number: all numbers of a row side by side fill whole vectors, those of a point do not.
        let mut each = [[0.0; N]; LANES];
        for (each, weight) in each.iter_mut().zip(weights) {
            *each = [*weight; N];
        }
        let numbers = out.as_flattened_mut().iter_mut().zip(greatest.as_flattened_mut());
        let parts = values.as_flattened().iter().zip(each.as_flattened());
        for ((out, greatest), (part, weight)) in numbers.zip(parts) {
            let counts = *weight > 0.0;
            *out += select_unpredictable(counts, weight * part, 0.0);
            *greatest = greatest.max(select_unpredictable(counts, *part, f32::NEG_INFINITY));
        }
    }
}

impl<const N: usize> Attribute<N> for Parts<N> {
    fn sampler(&self) -> Box<dyn Sampler<N> + '_> {
        Box::new(PartsSampler {
            parts: self,
            evaluators: self.parts.iter().map(|(field, _)| field.evaluator()).collect(),
            samplers: self.parts.iter().map(|(_, colour)| colour.sampler()).collect(),
            distances: vec![[0.0; BATCH]; self.parts.len()],
            weights: vec![[0.0; BATCH]; self.parts.len()],
            values: [[0.0; N]; BATCH],
            greatest: [[0.0; N]; BATCH],
        })
    }
}

struct PartsSampler<'a, const N: usize> {
    parts: &'a Parts<N>,
    evaluators: Vec<Box<dyn Evaluator + 'a>>,
    samplers: Vec<Box<dyn Sampler<N> + 'a>>,
    distances: Vec<[f32; BATCH]>,
    weights: Vec<[f32; BATCH]>,
    values: [[f32; N]; BATCH],
    greatest: [[f32; N]; BATCH],
}

impl<const N: usize> Sampler<N> for PartsSampler<'_, N> {
    fn enter(&mut self, region: &Aabb) {
        self.evaluators.iter_mut().for_each(|evaluator| evaluator.enter(region));
        self.samplers.iter_mut().for_each(|sampler| sampler.enter(region));
    }

    fn leave(&mut self) {
        self.evaluators.iter_mut().for_each(|evaluator| evaluator.leave());
        self.samplers.iter_mut().for_each(|sampler| sampler.leave());
    }

    fn sample(&mut self, points: &Points, out: &mut [[f32; N]; BATCH]) {
        for (evaluator, distances) in self.evaluators.iter_mut().zip(&mut self.distances) {
            evaluator.values(points, distances);
        }
        self.parts.weigh(&self.distances, &mut self.weights, points.len);
        out[..points.len].fill([0.0; N]);
        self.greatest[..points.len].fill([f32::NEG_INFINITY; N]);
        for (sampler, weights) in self.samplers.iter_mut().zip(&self.weights) {
            if weights[..points.len].iter().all(|weight| *weight == 0.0) {
                continue;
            }
            sampler.sample(points, &mut self.values);
            add(&self.values, weights, points.len, out, &mut self.greatest);
        }
        // Weights sum to 1 but for rounding, which must not make a mean greater than all that is in it.
        for (out, greatest) in out[..points.len].iter_mut().zip(&self.greatest) {
            for (out, greatest) in out.iter_mut().zip(greatest) {
                if *out > *greatest {
                    *out = *greatest;
                }
            }
        }
    }

    /// Weights are convex: what all parts' bounds hold.
    fn bounds(&mut self, region: &Aabb) -> [Interval; N] {
        let all = self.samplers.iter_mut().map(|sampler| sampler.bounds(region));
        let both = |a: [Interval; N], b: [Interval; N]| std::array::from_fn(|i| a[i].union(b[i]));
        all.reduce(both).unwrap_or([Interval::ALL; N])
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::attribute::{Constant, LinearRgb};
    use crate::field::{Hint, Hints};

    const RED: LinearRgb = [1.0, 0.0, 0.0];
    const BLUE: LinearRgb = [0.0, 0.0, 1.0];

    /// A ball on the x axis.
    struct Ball(f64, f64);

    impl Field for Ball {
        fn bounding_box(&self) -> Option<Aabb> {
            None
        }

        fn reference(&self, position: DVec3) -> f64 {
            self.1 - position.distance(DVec3::new(self.0, 0.0, 0.0))
        }

        fn evaluator(&self) -> Box<dyn Evaluator + '_> {
            Box::new(BallEvaluator(self))
        }
    }

    struct BallEvaluator<'a>(&'a Ball);

    impl Evaluator for BallEvaluator<'_> {
        fn enter(&mut self, _region: &Aabb) {}

        fn bounds(&mut self) -> Interval {
            Interval::ALL
        }

        fn hints(&mut self, _: Hint) -> Hints {
            Hints::NONE
        }

        fn leave(&mut self) {}

        fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
            (0..points.len).for_each(|i| out[i] = self.0.reference(points.position(i)) as f32);
        }

        fn gradients(&mut self, _points: &Points, _out: &mut crate::field::Gradients) {
            unreachable!("colours need no gradients")
        }
    }

    fn balls(first: LinearRgb, second: LinearRgb, apart: f64, rule: Rule) -> Parts<3> {
        let part = |x: f64, colour| -> Part<3> { (Arc::new(Ball(x, 1.0)), Arc::new(Constant::new(colour))) };
        Parts::new(vec![part(0.0, first), part(apart, second)], rule, 1e-6).expect("parts")
    }

    fn along_x(parts: &Parts<3>, places: &[f64]) -> Vec<LinearRgb> {
        let mut points = Points::new(DVec3::ZERO);
        places.iter().for_each(|x| points.push(Vec3::new(*x as f32, 0.0, 0.0)));
        let mut out = [[0.0; 3]; BATCH];
        parts.sampler().sample(&points, &mut out);
        out[..places.len()].to_vec()
    }

    #[test]
    fn inside_a_part_its_own_colour_and_the_later_one_in_an_overlap() {
        let parts = balls(RED, BLUE, 1.5, Rule::Union { seam: 0.0 });
        let colours = along_x(&parts, &[0.0, 0.49, 0.51, 0.8, 1.0, 2.5]);
        assert_eq!(colours, [RED, RED, BLUE, BLUE, BLUE, BLUE]);
        // On the surface, a rounding error outside.
        assert_eq!(along_x(&parts, &[-1.000_000_4])[0], RED);
    }

    #[test]
    fn partitions_share_overlaps_by_priority_or_evenly_and_gaps_go_to_the_master() {
        let at = |overlap, master, places: &[f64]| {
            along_x(&balls(RED, BLUE, 1.5, Rule::Partitions { overlap, master }), places)
        };
        // Inside the first, both, the second, none.
        let places = [0.0, 0.75, 1.5, 3.5];
        assert_eq!(at(Overlap::Priority, Some(0), &places), [RED, BLUE, BLUE, RED]);
        assert_eq!(at(Overlap::Priority, Some(1), &places), [RED, BLUE, BLUE, BLUE]);
        assert_eq!(at(Overlap::Mix, Some(0), &places), [RED, [0.5, 0.0, 0.5], BLUE, RED]);
        // Without a master the nearest.
        for overlap in [Overlap::Priority, Overlap::Mix] {
            assert_eq!(at(overlap, None, &[-1.5, 0.0, 1.5, 3.5]), [RED, RED, BLUE, BLUE]);
        }
    }

    #[test]
    fn outside_by_the_inverse_of_the_distances() {
        let parts = balls(RED, BLUE, 4.0, Rule::Union { seam: 0.0 });
        for x in [1.1, 1.7, 2.6] {
            let (one, two) = (1.0 / (x - 1.0), 1.0 / (3.0 - x));
            let red = along_x(&parts, &[x])[0][0];
            assert!((f64::from(red) - one / (one + two)).abs() < 1e-5);
        }
    }

    #[test]
    fn parts_of_one_colour_give_that_colour() {
        let places: Vec<f64> = (0..400).map(|i| f64::from(i) * 0.013 - 2.0).collect();
        for rule in [Rule::Union { seam: 0.0 }, Rule::Union { seam: 0.3 }, Rule::Blend] {
            for colour in along_x(&balls(RED, RED, 1.4, rule), &places) {
                assert!((1.0 - 1e-6..=1.0).contains(&colour[0]) && colour[1..] == [0.0; 2], "{colour:?}");
            }
        }
    }

    #[test]
    fn a_seam_and_a_blend_have_no_edges() {
        let places: Vec<f64> = (0..500).map(|i| f64::from(i) * 0.01 - 1.5).collect();
        for rule in [Rule::Union { seam: 0.4 }, Rule::Blend] {
            let colours = along_x(&balls(RED, BLUE, 1.5, rule), &places);
            let jump = colours.windows(2).map(|two| (two[1][0] - two[0][0]).abs()).fold(0.0, f32::max);
            assert!(jump < 0.08, "{rule:?} jumps by {jump}");
        }
        let soft = balls(RED, BLUE, 1.5, Rule::Union { seam: 0.4 });
        assert_eq!(along_x(&soft, &[0.0, 1.0]), [RED, BLUE]);
        assert_eq!(along_x(&balls(RED, BLUE, 3.0, Rule::Blend), &[-1.0, 1.0, 2.0]), [RED, RED, BLUE]);
    }
}
