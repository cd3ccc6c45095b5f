//! What touching blocks have for each other: the layers of voxels at their faces, and the feet of those.

use glam::{IVec3, USizeVec3, Vec3};
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
        self.copy_layer(values, &mut layer);
        layer
    }

    fn copy_layer(self, values: &[f32; BLOCK_VOXELS], layer: &mut [f32; LAYER]) {
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
    }

    fn index(self) -> usize {
        usize::from(self.0)
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

/// What tells of the voxels at one face of a block whether feet are nearer to those behind it.
#[derive(Clone, Copy)]
pub struct Side {
    /// Signed.
    distances: [f32; LAYER],
    /// The gradients' part across the face.
    across: [f32; LAYER],
}

impl Side {
    /// To be filled.
    pub const NONE: Self = Self { distances: [0.0; LAYER], across: [0.0; LAYER] };

    /// Fills in those of a block's distances and their gradients, by face.
    pub fn fill_all(distances: &[f32; BLOCK_VOXELS], normals: &[[f32; BLOCK_VOXELS]; 3], sides: &mut [Self; 6]) {
        for (face, side) in Face::ALL.into_iter().zip(sides) {
            let (axis, _) = face.across();
            face.copy_layer(distances, &mut side.distances);
            face.copy_layer(&normals[axis], &mut side.across);
        }
    }
}

/// The voxels at one face of a block, and their feet.
pub struct Layer<'a> {
    face: Face,
    voxel: f32,
    block: OfBlock<'a>,
}

/// Where a layer's distances and gradients are looked up; few gradients are asked for.
enum OfBlock<'a> {
    Whole(&'a Staged),
    /// The side, and the gradients at it by axis.
    Kept(Box<(Side, [[f32; LAYER]; 3])>),
}

impl<'a> Layer<'a> {
    /// The layer of a block at a face, for voxels of an edge.
    pub fn new(block: &'a Staged, face: Face, voxel: f32) -> Self {
        Self { face, voxel, block: OfBlock::Whole(block) }
    }

    /// A layer to be kept without the block.
    pub fn kept(block: &Staged, face: Face, voxel: f32) -> Layer<'static> {
        let normals = block.normals.each_ref().map(|normals| face.layer(normals));
        Layer { face, voxel, block: OfBlock::Kept(Box::new((block.sides[face.index()], normals))) }
    }

    fn side(&self) -> &Side {
        match &self.block {
            OfBlock::Whole(block) => &block.sides[self.face.index()],
            OfBlock::Kept(kept) => &kept.0,
        }
    }

    /// Lists what `other`, the facing layer of the neighbour, has that is within reach and nearer than this block's
    /// own.
    pub fn offers(&self, other: &Layer, reach: f32, seeds: &mut Vec<Seed>) {
        let (here, there) = (&self.side().distances, &other.side().distances);
        other.offer_feet(here, reach, seeds);
        if !any_crossing(self.voxel, here, there) {
            return;
        }
        for (k, (&here, &there)) in here.iter().zip(there).enumerate() {
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
        if !find_nearer(self.voxel, reach, self.side(), step, distances, &mut nearer) {
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
        let centre = (USizeVec3::new(i >> 6, i >> 3 & 7, i & 7).as_vec3() - 3.5) * self.voxel;
        let normal = match &self.block {
            OfBlock::Whole(block) => block.normals.each_ref().map(|normals| normals[i]),
            OfBlock::Kept(kept) => kept.1.each_ref().map(|normals| normals[k]),
        };
        centre - Vec3::from_array(normal) * self.side().distances[k]
    }
}

/// Flags the voxels of the facing layer, a `step` behind this one, that feet of this one are nearer to than their own
/// are, at `others`; whether there are any.
#[multiversion(targets = "simd")]
fn find_nearer(
    voxel: f32,
    reach: f32,
    Side { distances, across }: &Side,
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
