//! Values outside of a body that do not jump: those of the nearest places of its surface, which do where two places are as
//! near, averaged on a lattice of their own.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::nodes::Body;
use crate::field::{BATCH, Points};

/// Cells along the body's longest side.
const ALONG: f64 = 64.0;
/// How far the lattice goes beyond the body, in its longest side. Farther away values are those of its border.
const MARGIN: f64 = 0.25;
/// How often each node outside becomes the mean of its neighbours: jumps go over some five cells then.
const ROUNDS: usize = 8;
/// How far from the surface only the lattice counts, in its cells: at the surface it is the nearest place alone, so that
/// inside and outside meet.
const BESIDE: f64 = 2.0;

/// Values on a lattice around a body.
pub(super) struct Outside {
    origin: DVec3,
    edge: f64,
    counts: [usize; 3],
    /// How many values a node has.
    width: usize,
    values: Vec<f32>,
}

impl Outside {
    /// `sampler` makes what gives values at points: `width` for each, one point after the other.
    pub fn new<S: FnMut(&Points, &mut [f32])>(body: &Body, width: usize, sampler: impl Fn() -> S + Sync) -> Self {
        let aabb = body.aabb();
        let longest = aabb.size().max_element();
        let (edge, aabb) = (longest / ALONG, aabb.grown(longest * MARGIN));
        let counts = (aabb.size() / edge).ceil().to_array().map(|cells| cells as usize + 1);
        let mut found =
            Self { origin: aabb.min, edge, counts, width, values: vec![0.0; counts.iter().product::<usize>() * width] };
        let mut is_outside = vec![false; counts.iter().product()];
        let mut all = std::mem::take(&mut found.values);
        let batches = all.par_chunks_mut(BATCH * width).zip(is_outside.par_chunks_mut(BATCH));
        batches.enumerate().for_each_init(
            || (sampler(), body.distance().evaluator(), [0.0; BATCH]),
            |(sample, distance, depths), (batch, (values, is_outside))| {
                let first = found.position(batch * BATCH);
                let mut points = Points::new(first);
                let offset = |node: usize| (found.position(batch * BATCH + node) - first).as_vec3();
                (0..is_outside.len()).for_each(|node| points.push(offset(node)));
                sample(&points, values);
                distance.values(&points, depths);
                is_outside.iter_mut().zip(depths).for_each(|(is_outside, depth)| *is_outside = *depth < 0.0);
            },
        );
        found.values = all;
        for _ in 0..ROUNDS {
            found.average(&is_outside);
        }
        found
    }

    fn at(&self, node: usize) -> [usize; 3] {
        let [_, y, z] = self.counts;
        [node / (y * z), node / z % y, node % z]
    }

    fn position(&self, node: usize) -> DVec3 {
        self.origin + DVec3::from(self.at(node).map(|part| part as f64)) * self.edge
    }

    /// Gives each node outside the mean of its neighbours.
    fn average(&mut self, is_outside: &[bool]) {
        let (before, width) = (std::mem::take(&mut self.values), self.width);
        let strides = [self.counts[1] * self.counts[2], self.counts[2], 1];
        let mut after = before.clone();
        after.par_chunks_mut(width).enumerate().filter(|(node, _)| is_outside[*node]).for_each(|(node, values)| {
            let at = self.at(node);
            values.fill(0.0);
            let mut count = 0.0;
            for axis in 0..3 {
                let before_it = (at[axis] > 0).then(|| node - strides[axis]);
                let after_it = (at[axis] + 1 < self.counts[axis]).then(|| node + strides[axis]);
                for beside in before_it.into_iter().chain(after_it) {
                    count += 1.0;
                    values.iter_mut().zip(&before[beside * width..]).for_each(|(value, other)| *value += other);
                }
            }
            values.iter_mut().for_each(|value| *value /= count);
        });
        self.values = after;
    }

    /// Mixes values at a position outside, so far from the surface, units, which are those of its nearest place, with the
    /// lattice's.
    pub fn mix(&self, position: DVec3, away: f32, values: &mut [f32]) {
        let share = (f64::from(away) / (BESIDE * self.edge)).clamp(0.0, 1.0) as f32;
        let share = share * share * (3.0 - 2.0 * share);
        let last = DVec3::from(self.counts.map(|count| (count - 1) as f64));
        let place = ((position - self.origin) / self.edge).clamp(DVec3::ZERO, last);
        let cell = place.floor().min(last - 1.0);
        let (within, cell) = ((place - cell).as_vec3(), cell.to_array().map(|part| part as usize));
        values.iter_mut().for_each(|value| *value *= 1.0 - share);
        for corner in 0..8 {
            let way = [corner >> 2, corner >> 1 & 1, corner & 1];
            let at: [usize; 3] = std::array::from_fn(|axis| cell[axis] + way[axis]);
            let ways =
                Vec3::from(std::array::from_fn(|axis| if way[axis] == 1 { within[axis] } else { 1.0 - within[axis] }));
            let node = (at[0] * self.counts[1] + at[1]) * self.counts[2] + at[2];
            let of_corner = &self.values[node * self.width..];
            values
                .iter_mut()
                .zip(of_corner)
                .for_each(|(value, other)| *value += share * ways.element_product() * other);
        }
    }
}
