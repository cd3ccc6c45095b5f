//! Feet handed from voxel to voxel: the vector distance transform (Danielsson) inside a block.
//!
//! A voxel's own Newton iteration finds *a* foot; a neighbour's may be nearer. Sweeps along each axis and back carry
//! the nearest foot seen so far through the block, as the transform does, with sub-voxel feet on F = 0. Between blocks
//! the feet of facing layers are compared.

use glam::{IVec3, Vec3};
use multiversion::multiversion;

use crate::{
    field::Points,
    grid::{BLOCK_EDGE, BLOCK_VOXELS},
};

use super::staged::Staged;

/// How much nearer a neighbour's foot must be to be taken, in voxels: feet are right to about a hundredth, and
/// smaller would polish again what is already right.
pub const NEARER: f32 = 0.01;

/// Replaces each voxel's foot by a nearer one of a neighbour's; returns whether any was, and marks them in `changed`.
/// Feet well beyond `reach` are not offered: the voxel is not in the band.
pub fn sweep(
    voxel: f32,
    reach: f32,
    points: &Points,
    feet: &mut Points,
    distances: &mut [f32; BLOCK_VOXELS],
    changed: &mut [bool; BLOCK_VOXELS],
) -> bool {
    let mut limits = [0.0; BLOCK_VOXELS];
    for (limit, &distance) in limits.iter_mut().zip(distances.iter()) {
        *limit = limit_of(voxel, reach, distance);
    }
    if !any_nearer(&limits, points, feet, distances) {
        return false;
    }
    let mut any = false;
    for stride in [64, 8, 1] {
        // Whether a step by `stride` from i stays in the block.
        let last = |i: usize| (i / stride) % 8 == 7;
        for i in (0..BLOCK_VOXELS).filter(|&i| !last(i)) {
            any |= offer(voxel, reach, points, feet, distances, changed, [i, i + stride]);
        }
        for i in (0..BLOCK_VOXELS).rev().filter(|&i| !last(i)) {
            any |= offer(voxel, reach, points, feet, distances, changed, [i + stride, i]);
        }
    }
    any
}

/// How far beyond reach a foot is still taken, in voxels: polishing brings it nearer. A neighbour's foot is off by about
/// a voxel along the surface, at most a sixth of a voxel in distance at reach 3.
const BEYOND: f32 = 0.25;

/// The square of the distance that an offered foot must undercut.
fn limit_of(voxel: f32, reach: f32, distance: f32) -> f32 {
    let limit = (distance - NEARER * voxel).min(reach + BEYOND * voxel).max(0.0);
    limit * limit
}

/// Whether a sweep would find anything: the usual answer is no, and a plain loop finds that out fast.
#[multiversion(targets = "simd")]
fn any_nearer(limits: &[f32; BLOCK_VOXELS], points: &Points, feet: &Points, distances: &[f32; BLOCK_VOXELS]) -> bool {
    let square = |from: usize, to: usize| {
        let (dx, dy, dz) = (feet.x[from] - points.x[to], feet.y[from] - points.y[to], feet.z[from] - points.z[to]);
        dx * dx + dy * dy + dz * dz
    };
    let mut any = false;
    for stride in [64, 8, 1] {
        // Runs of voxels whose neighbours at `stride` are in the block.
        for start in (0..BLOCK_VOXELS).step_by(8 * stride) {
            for low in start..start + 7 * stride {
                let high = low + stride;
                any |= (distances[low] < f32::INFINITY) & (square(low, high) < limits[high]);
                any |= (distances[high] < f32::INFINITY) & (square(high, low) < limits[low]);
            }
        }
    }
    any
}

fn offer(
    voxel: f32,
    reach: f32,
    points: &Points,
    feet: &mut Points,
    distances: &mut [f32; BLOCK_VOXELS],
    changed: &mut [bool; BLOCK_VOXELS],
    [from, to]: [usize; 2],
) -> bool {
    if distances[from] == f32::INFINITY {
        return false;
    }
    let square = (feet.offset(from) - points.offset(to)).length_squared();
    let nearer = square < limit_of(voxel, reach, distances[to]);
    if nearer {
        distances[to] = square.sqrt();
        (feet.x[to], feet.y[to], feet.z[to]) = (feet.x[from], feet.y[from], feet.z[from]);
        changed[to] = true;
    }
    nearer
}

/// A face of a block: towards less (even) or more (odd) x, y or z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Face(u8);

impl Face {
    /// All six.
    pub const ALL: [Self; 6] = [Self(0), Self(1), Self(2), Self(3), Self(4), Self(5)];

    /// The face of the neighbour that touches this one.
    pub fn facing(self) -> Self {
        Self(self.0 ^ 1)
    }

    /// From a block's corner or middle to its neighbour's, in voxels.
    pub fn step(self) -> IVec3 {
        let mut step = IVec3::ZERO;
        step[usize::from(self.0 / 2)] = if self.0 & 1 == 0 { -BLOCK_EDGE } else { BLOCK_EDGE };
        step
    }

    /// A block's values in the layer at this face; facing layers are in the same order.
    pub fn layer(self, values: &[f32; BLOCK_VOXELS]) -> [f32; 64] {
        std::array::from_fn(|k| values[self.voxel(k)])
    }

    /// The k-th voxel of the layer at this face; facing layers agree on k.
    fn voxel(self, k: usize) -> usize {
        let depth = if self.0 & 1 == 0 { 0 } else { 7 };
        let (u, v) = (k >> 3, k & 7);
        match self.0 / 2 {
            0 => depth << 6 | u << 3 | v,
            1 => u << 6 | depth << 3 | v,
            _ => u << 6 | v << 3 | depth,
        }
    }
}

/// What a neighbouring block offers to one voxel.
#[derive(Clone, Copy)]
pub struct Seed {
    /// The voxel's number in its block.
    pub voxel: u16,
    /// What it is offered.
    pub offer: Offer,
}

/// A point of the surface that may be nearer than a voxel's own foot.
#[derive(Clone, Copy)]
pub enum Offer {
    /// A neighbour's foot, as an offset from the block's middle.
    Foot(Vec3),
    /// The surface passes between the voxel and its neighbour this far away.
    Crossing(Vec3),
}

/// How much more than a voxel the distances of two neighbours of different sign may add up to, in voxels: feet are
/// right to a hundredth each.
const CROSSED: f32 = 1.0 + 2.0 * NEARER;

/// Whether two neighbouring voxels with these signed distances are of different sign, and both farther from the surface
/// than they can be: it passes between them.
#[inline(always)]
pub fn miss_a_crossing(voxel: f32, here: f32, there: f32) -> bool {
    ((here >= 0.0) != (there >= 0.0)) & (here.abs() + there.abs() > CROSSED * voxel)
}

/// Whether any two neighbours in a block miss a crossing. The usual answer is no, and a plain loop finds that out fast.
#[multiversion(targets = "simd")]
pub fn any_crossing_missed(voxel: f32, signed: &[f32; BLOCK_VOXELS]) -> bool {
    let mut any = false;
    for stride in [64, 8, 1] {
        for start in (0..BLOCK_VOXELS).step_by(8 * stride) {
            for low in start..start + 7 * stride {
                any |= miss_a_crossing(voxel, signed[low], signed[low + stride]);
            }
        }
    }
    any
}

/// The voxels at one face of a block: their signed distances and their feet.
#[derive(Clone)]
pub struct Layer {
    face: Face,
    voxel: f32,
    distances: [f32; 64],
    /// Offsets from the block's middle; not a number where a voxel has none.
    feet: [Vec3; 64],
}

impl Layer {
    /// The layer of a block at a face, for voxels of an edge.
    pub fn new(block: &Staged, face: Face, voxel: f32) -> Self {
        let foot = |k| {
            let i = face.voxel(k);
            block.to_foot(i).map_or(Vec3::NAN, |to_foot| centre(i, voxel) + to_foot)
        };
        Self { face, voxel, distances: face.layer(&block.distances), feet: std::array::from_fn(foot) }
    }

    /// Lists what `other`, the facing layer of the neighbour, has that is within reach and nearer than this block's
    /// own.
    pub fn offers(&self, other: &Self, reach: f32, seeds: &mut Vec<Seed>) {
        other.offer_feet(&self.distances, reach, seeds);
        for (k, (&here, &there)) in self.distances.iter().zip(&other.distances).enumerate() {
            if miss_a_crossing(self.voxel, here, there) {
                let step = self.face.step().as_vec3() * (self.voxel / BLOCK_EDGE as f32);
                seeds.push(Seed { voxel: self.face.voxel(k) as u16, offer: Offer::Crossing(step) });
            }
        }
    }

    /// Lists the feet that are within reach and nearer than those of the facing layer of the neighbour, of which the
    /// distances are given.
    pub fn offer_feet(&self, distances: &[f32; 64], reach: f32, seeds: &mut Vec<Seed>) {
        let facing = self.face.facing();
        let shift = facing.step().as_vec3() * self.voxel;
        for (k, (foot, distance)) in self.feet.iter().zip(distances).enumerate() {
            let i = facing.voxel(k);
            let foot = *foot + shift;
            let square = (foot - centre(i, self.voxel)).length_squared();
            if square < limit_of(self.voxel, reach, distance.abs()) {
                seeds.push(Seed { voxel: i as u16, offer: Offer::Foot(foot) });
            }
        }
    }
}

/// A voxel's offset from its block's middle.
fn centre(i: usize, voxel: f32) -> Vec3 {
    (Vec3::new((i >> 6) as f32, (i >> 3 & 7) as f32, (i & 7) as f32) - 3.5) * voxel
}
