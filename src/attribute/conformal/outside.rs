//! Values outside of a body that do not jump: those of the nearest places of its surface, which do where two places are as
//! near, carried on and averaged on a lattice of their own.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::nodes::Body;
use crate::field::{BATCH, Evaluator, Points};

/// Cells along the body's longest side.
const ALONG: f64 = 64.0;
/// How far the lattice goes beyond the body, in its longest side. Farther away values are those of its border.
const MARGIN: f64 = 0.25;
/// How far from the surface nearest places are looked for, in cells. Farther away nodes have what those nearer to it have.
const FOUND: f64 = 2.0;
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
    pub fn new<S: FnMut(&Points, &mut [f32])>(
        body: &Body,
        width: usize,
        sampler: impl Fn() -> S + Send + Sync,
    ) -> Self {
        let aabb = body.aabb();
        let longest = aabb.size().max_element();
        let (edge, aabb) = (longest / ALONG, aabb.grown(longest * MARGIN));
        let counts = (aabb.size() / edge).ceil().to_array().map(|cells| cells as usize + 1);
        let count = counts.iter().product::<usize>();
        let mut found = Self { origin: aabb.min, edge, counts, width, values: vec![0.0; count * width] };
        let nodes: Vec<usize> = (0..count).collect();
        let depth_of_batch = |distance: &mut Box<dyn Evaluator + '_>, batch: &[usize]| {
            let mut depths = [0.0; BATCH];
            distance.values(&found.points(batch), &mut depths);
            depths[..batch.len()].to_vec()
        };
        let evaluator = || body.distance().evaluator();
        let depths: Vec<f32> = nodes.par_chunks(BATCH).map_init(evaluator, depth_of_batch).flatten_iter().collect();
        let near = |node: &usize| f64::from(depths[*node]).abs() <= FOUND * edge;
        let nodes: Vec<usize> = nodes.into_iter().filter(near).collect();
        let sample_batch = |sample: &mut S, batch: &[usize]| {
            let mut values = vec![0.0; batch.len() * width];
            sample(&found.points(batch), &mut values);
            values
        };
        let sampled: Vec<f32> = nodes.par_chunks(BATCH).map_init(sampler, sample_batch).flatten_iter().collect();
        let mut is_known = vec![false; count];
        for (node, values) in nodes.into_iter().zip(sampled.chunks_exact(width)) {
            is_known[node] = true;
            found.values[node * width..][..width].copy_from_slice(values);
        }
        let is_outside: Vec<bool> = depths.into_iter().map(|depth| depth < 0.0).collect();
        // Layer by layer away from the body, then all.
        while found.average(&mut is_known, |node, is_known| is_outside[node] && !is_known) {}
        for _ in 0..ROUNDS {
            found.average(&mut is_known, |node, _| is_outside[node]);
        }
        found
    }

    fn points(&self, nodes: &[usize]) -> Points {
        let first = self.position(nodes[0]);
        let mut points = Points::new(first);
        nodes.iter().for_each(|node| points.push((self.position(*node) - first).as_vec3()));
        points
    }

    fn at(&self, node: usize) -> [usize; 3] {
        let [_, y, z] = self.counts;
        [node / (y * z), node / z % y, node % z]
    }

    fn position(&self, node: usize) -> DVec3 {
        self.origin + DVec3::from(self.at(node).map(|part| part as f64)) * self.edge
    }

    /// Gives some nodes, asked for by their numbers and by whether they are known, the mean of those of their neighbours that
    /// are; whether any had such.
    fn average(&mut self, is_known: &mut [bool], is_asked: impl Fn(usize, bool) -> bool + Sync) -> bool {
        let (width, counts) = (self.width, self.counts);
        let strides = [counts[1] * counts[2], counts[2], 1];
        let (before, was_known) = (self.values.clone(), is_known.to_vec());
        let mut values = std::mem::take(&mut self.values);
        let mean = |(node, (values, is_known)): (usize, (&mut [f32], &mut bool))| {
            let at = self.at(node);
            let beside = |axis: usize| {
                let less = (at[axis] > 0).then(|| node - strides[axis]);
                let more = (at[axis] + 1 < counts[axis]).then(|| node + strides[axis]);
                less.into_iter().chain(more)
            };
            let known = || (0..3).flat_map(beside).filter(|beside| was_known[*beside]);
            let count = known().count();
            if count == 0 {
                return false;
            }
            values.fill(0.0);
            for other in known() {
                values.iter_mut().zip(&before[other * width..]).for_each(|(value, other)| *value += other);
            }
            values.iter_mut().for_each(|value| *value /= count as f32);
            *is_known = true;
            true
        };
        let nodes = values.par_chunks_mut(width).zip(is_known.par_iter_mut()).enumerate();
        let asked = nodes.filter(|(node, (_, is_known))| is_asked(*node, **is_known));
        let found = asked.map(mean).reduce(|| false, |one, two| one | two);
        self.values = values;
        found
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
