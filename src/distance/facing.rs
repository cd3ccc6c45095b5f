//! What touching blocks have for each other: the layers of voxels at their faces, and the feet of those.

use glam::{IVec3, Vec3};
use multiversion::multiversion;

use crate::grid::{BLOCK_EDGE, BLOCK_VOXELS};

use super::{
    exchange::{limit_of, miss_a_crossing},
    staged::Staged,
};

/// Voxels in a layer.
const LAYER: usize = 64;

/// A face of a block: towards less (even) or more (odd) x, y or z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Face(u8);

impl Face {
    /// All six.
    pub const ALL: [Self; 6] = [Self(0), Self(1), Self(2), Self(3), Self(4), Self(5)];
    /// Those towards more: of two blocks that touch, one has the other there.
    pub const FORWARD: [Self; 3] = [Self(1), Self(3), Self(5)];

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

    fn depth(self) -> usize {
        if self.0 & 1 == 0 { 0 } else { 7 }
    }

    /// The k-th voxel of the layer at this face; facing layers agree on k.
    fn voxel(self, k: usize) -> usize {
        let (depth, u, v) = (self.depth(), k >> 3, k & 7);
        match self.0 / 2 {
            0 => depth << 6 | u << 3 | v,
            1 => u << 6 | depth << 3 | v,
            _ => u << 6 | v << 3 | depth,
        }
    }

    /// A block's values in the layer at this face; facing layers are in the same order.
    pub fn layer(self, values: &[f32; BLOCK_VOXELS]) -> [f32; LAYER] {
        let mut layer = [0.0; LAYER];
        match self.0 / 2 {
            0 => layer.copy_from_slice(&values[self.depth() << 6..][..LAYER]),
            1 => {
                for (row, values) in layer.as_chunks_mut::<8>().0.iter_mut().zip(values.as_chunks::<64>().0) {
                    row.copy_from_slice(&values[self.depth() << 3..][..8]);
                }
            }
            _ => {
                for (value, values) in layer.iter_mut().zip(values.as_chunks::<8>().0) {
                    *value = values[self.depth()];
                }
            }
        }
        layer
    }

    /// The voxels' offsets from their block's middle, by axis.
    fn centres(self, voxel: f32) -> [[f32; LAYER]; 3] {
        let at = |i: usize| (i as f32 - 3.5) * voxel;
        let (depth, u, v) =
            ([at(self.depth()); LAYER], std::array::from_fn(|k| at(k >> 3)), std::array::from_fn(|k| at(k & 7)));
        match self.0 / 2 {
            0 => [depth, u, v],
            1 => [u, depth, v],
            _ => [u, v, depth],
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

/// The voxels at one face of a block: their signed distances and their feet.
#[derive(Clone)]
pub struct Layer {
    face: Face,
    voxel: f32,
    distances: [f32; LAYER],
    /// Offsets from the block's middle, by axis; not a number where a voxel has none.
    feet: [[f32; LAYER]; 3],
}

impl Layer {
    /// The layer of a block at a face, for voxels of an edge.
    pub fn new(block: &Staged, face: Face, voxel: f32) -> Self {
        let distances = face.layer(&block.distances);
        let mut feet = face.centres(voxel);
        for (feet, normals) in feet.iter_mut().zip(&block.normals) {
            step_to_feet(&distances, &face.layer(normals), feet);
        }
        Self { face, voxel, distances, feet }
    }

    /// Lists what `other`, the facing layer of the neighbour, has that is within reach and nearer than this block's
    /// own.
    pub fn offers(&self, other: &Self, reach: f32, seeds: &mut Vec<Seed>) {
        other.offer_feet(&self.distances, reach, seeds);
        if !any_crossing(self.voxel, &self.distances, &other.distances) {
            return;
        }
        for (k, (&here, &there)) in self.distances.iter().zip(&other.distances).enumerate() {
            if miss_a_crossing(self.voxel, here, there) {
                let step = self.face.step().as_vec3() * (self.voxel / BLOCK_EDGE as f32);
                seeds.push(Seed { voxel: self.face.voxel(k) as u16, offer: Offer::Crossing(step) });
            }
        }
    }

    /// Lists the feet that are within reach and nearer than those of the facing layer of the neighbour, of which the
    /// distances are given.
    pub fn offer_feet(&self, distances: &[f32; LAYER], reach: f32, seeds: &mut Vec<Seed>) {
        let facing = self.face.facing();
        let shift = (facing.step().as_vec3() * self.voxel).to_array();
        let mut nearer = [0; LAYER];
        if !find_nearer(self.voxel, reach, &self.feet, shift, &facing.centres(self.voxel), distances, &mut nearer) {
            return;
        }
        for k in (0..LAYER).filter(|&k| nearer[k] != 0) {
            let foot = Vec3::from_array([0, 1, 2].map(|axis| self.feet[axis][k] + shift[axis]));
            seeds.push(Seed { voxel: facing.voxel(k) as u16, offer: Offer::Foot(foot) });
        }
    }
}

/// Moves voxels along an axis to their feet; where there is none, to where is not a number.
#[multiversion(targets = "simd")]
fn step_to_feet(distances: &[f32; LAYER], normals: &[f32; LAYER], positions: &mut [f32; LAYER]) {
    for k in 0..LAYER {
        let foot = positions[k] + normals[k] * -distances[k];
        positions[k] = if distances[k].abs() < f32::INFINITY { foot } else { f32::NAN };
    }
}

/// Flags the voxels at `centres` to which `feet` are nearer than what they have; whether there are any.
#[multiversion(targets = "simd")]
fn find_nearer(
    voxel: f32,
    reach: f32,
    feet: &[[f32; LAYER]; 3],
    shift: [f32; 3],
    centres: &[[f32; LAYER]; 3],
    distances: &[f32; LAYER],
    nearer: &mut [u8; LAYER],
) -> bool {
    let mut any = 0;
    for k in 0..LAYER {
        let x = feet[0][k] + shift[0] - centres[0][k];
        let y = feet[1][k] + shift[1] - centres[1][k];
        let z = feet[2][k] + shift[2] - centres[2][k];
        nearer[k] = u8::from(x * x + y * y + z * z < limit_of(voxel, reach, distances[k].abs()));
        any |= nearer[k];
    }
    any != 0
}

/// Whether the surface passes unseen between any two voxels of facing layers.
#[multiversion(targets = "simd")]
fn any_crossing(voxel: f32, here: &[f32; LAYER], there: &[f32; LAYER]) -> bool {
    let mut any = false;
    for k in 0..LAYER {
        any |= miss_a_crossing(voxel, here[k], there[k]);
    }
    any
}
