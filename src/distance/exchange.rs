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
#[multiversion(targets("x86_64+avx+avx2", "x86_64+avx+avx2+avx512f+avx512bw+avx512dq+avx512vl"))]
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

/// A voxel and a foot offered to it, as an offset from the block's middle.
pub type Seed = (u16, Vec3);

/// The feet of the voxels at one face of a block.
#[derive(Clone)]
pub struct Layer {
    face: Face,
    voxel: f32,
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
        Self { face, voxel, feet: std::array::from_fn(foot) }
    }

    /// Lists the feet of `other`, the facing layer of the neighbour, that are within reach and nearer than this
    /// block's own.
    pub fn offers(&self, other: &Self, reach: f32, seeds: &mut Vec<Seed>) {
        let shift = self.face.step().as_vec3() * self.voxel;
        for (k, (own, offered)) in self.feet.iter().zip(&other.feet).enumerate() {
            let i = self.face.voxel(k);
            let centre = centre(i, self.voxel);
            let offered = *offered + shift;
            let distance = if own.is_nan() { f32::INFINITY } else { (*own - centre).length() };
            if (offered - centre).length_squared() < limit_of(self.voxel, reach, distance) {
                seeds.push((i as u16, offered));
            }
        }
    }
}

/// A voxel's offset from its block's middle.
fn centre(i: usize, voxel: f32) -> Vec3 {
    (Vec3::new((i >> 6) as f32, (i >> 3 & 7) as f32, (i & 7) as f32) - 3.5) * voxel
}
