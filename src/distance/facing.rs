//! What touching blocks have for each other: the layers of voxels at their faces, and the feet of those.

use glam::{IVec3, Vec3};
use multiversion::multiversion;

use crate::grid::{BLOCK_EDGE, BLOCK_VOXELS};

use super::{
    exchange::{limit_of, miss_a_crossing, square_beside},
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

    /// The axis across the face, and which way a step through it goes along it.
    fn across(self) -> (usize, f32) {
        (usize::from(self.0 / 2), if self.0 & 1 == 0 { -1.0 } else { 1.0 })
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

/// The voxels at one face of a block: their signed distances, and their feet.
pub struct Layer<'a> {
    face: Face,
    voxel: f32,
    distances: [f32; LAYER],
    /// The gradients' part across the face: with the distances it tells whether a foot is nearer to the voxel behind.
    across: [f32; LAYER],
    normals: Normals<'a>,
}

/// Where the gradients at a layer are looked up, of which few are asked for.
enum Normals<'a> {
    OfBlock(&'a Staged),
    /// By axis.
    Kept(Box<[[f32; LAYER]; 3]>),
}

impl<'a> Layer<'a> {
    /// The layer of a block at a face, for voxels of an edge.
    pub fn new(block: &'a Staged, face: Face, voxel: f32) -> Self {
        let (axis, _) = face.across();
        let (distances, across) = (face.layer(&block.distances), face.layer(&block.normals[axis]));
        Self { face, voxel, distances, across, normals: Normals::OfBlock(block) }
    }

    /// The same without the block.
    pub fn kept(self) -> Layer<'static> {
        let Self { face, voxel, distances, across, normals } = self;
        let normals = match normals {
            Normals::OfBlock(block) => Box::new(block.normals.each_ref().map(|normals| face.layer(normals))),
            Normals::Kept(normals) => normals,
        };
        Layer { face, voxel, distances, across, normals: Normals::Kept(normals) }
    }

    /// Lists what `other`, the facing layer of the neighbour, has that is within reach and nearer than this block's
    /// own.
    pub fn offers(&self, other: &Layer, reach: f32, seeds: &mut Vec<Seed>) {
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
        let step = self.face.across().1 * self.voxel;
        let mut nearer = [0; LAYER];
        if !find_nearer(self.voxel, reach, &self.distances, &self.across, step, distances, &mut nearer) {
            return;
        }
        let facing = self.face.facing();
        let shift = facing.step().as_vec3() * self.voxel;
        for k in (0..LAYER).filter(|&k| nearer[k] != 0) {
            seeds.push(Seed { voxel: facing.voxel(k) as u16, offer: Offer::Foot(self.foot(k) + shift) });
        }
    }

    /// The foot of the layer's k-th voxel, as an offset from the block's middle.
    fn foot(&self, k: usize) -> Vec3 {
        let i = self.face.voxel(k);
        let centre = (glam::USizeVec3::new(i >> 6, i >> 3 & 7, i & 7).as_vec3() - 3.5) * self.voxel;
        let normal = match &self.normals {
            Normals::OfBlock(block) => block.normals.each_ref().map(|normals| normals[i]),
            Normals::Kept(normals) => normals.each_ref().map(|normals| normals[k]),
        };
        centre - Vec3::from_array(normal) * self.distances[k]
    }
}

/// Flags the voxels of the facing layer, a `step` behind this one, that feet of this one are nearer to than their own
/// are, at `others`; whether there are any.
#[multiversion(targets = "simd")]
fn find_nearer(
    voxel: f32,
    reach: f32,
    distances: &[f32; LAYER],
    across: &[f32; LAYER],
    step: f32,
    others: &[f32; LAYER],
    nearer: &mut [u8; LAYER],
) -> bool {
    let mut any = 0;
    for k in 0..LAYER {
        let square = square_beside(distances[k] * distances[k], across[k] * distances[k], step);
        nearer[k] = u8::from(square < limit_of(voxel, reach, others[k].abs()));
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
