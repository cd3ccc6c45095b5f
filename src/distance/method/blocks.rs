//! Lattice nodes in leaf blocks, numbered one after the other, with their neighbours: what grid methods solve on.

use glam::IVec3;
use rayon::prelude::*;

use crate::grid::{BLOCK_EDGE, BLOCK_VOXELS, block_order, block_origin, place_of, voxel_offset};

/// No block there.
const NONE: u32 = u32::MAX;

/// The steps from a place in a block to the next one along x, y and z.
const STRIDES: [usize; 3] = [64, 8, 1];

/// Blocks of 8³ nodes. A node's number is 512 times its block's place in the list, plus its place in the block.
pub struct Blocks {
    /// The blocks' least corners, in the order of blocks.
    pub origins: Vec<IVec3>,
    /// The blocks that share a face with each: −x, +x, −y, +y, −z, +z.
    beside: Vec<[u32; 6]>,
}

impl Blocks {
    /// Blocks in the order of blocks, fewer than 2³².
    pub fn new(origins: Vec<IVec3>) -> Self {
        let beside = origins.par_iter().map(|&origin| {
            std::array::from_fn(|face| {
                let step = IVec3::AXES[face / 2] * if face % 2 == 0 { -BLOCK_EDGE } else { BLOCK_EDGE };
                place_of(&origins, origin + step).map_or(NONE, |place| place as u32)
            })
        });
        let beside = beside.collect();
        Self { beside, origins }
    }

    /// All blocks with a node from one voxel to another.
    pub fn filling(least: IVec3, greatest: IVec3) -> Self {
        let (first, last) = (block_origin(least), block_origin(greatest));
        let along = |axis: usize| (first[axis]..=last[axis]).step_by(BLOCK_EDGE as usize);
        let mut origins: Vec<IVec3> =
            along(0).flat_map(|x| along(1).flat_map(move |y| along(2).map(move |z| IVec3::new(x, y, z)))).collect();
        origins.sort_by_cached_key(|&origin| block_order(origin));
        Self::new(origins)
    }

    /// The least and the greatest node of blocks that fill a box.
    pub fn ends(&self) -> (IVec3, IVec3) {
        // In the order of blocks those at its corners come first and last.
        let end = |block: Option<&IVec3>| block.copied().unwrap_or_default();
        (end(self.origins.first()), end(self.origins.last()) + (BLOCK_EDGE - 1))
    }

    /// How many nodes there are.
    pub fn nodes(&self) -> usize {
        self.origins.len() * BLOCK_VOXELS
    }

    /// The neighbour across a face: −x, +x, −y, +y, −z, +z.
    #[inline(always)]
    pub fn beside(&self, node: usize, face: usize) -> Option<usize> {
        let (stride, onward) = (STRIDES[face / 2], face % 2 == 1);
        let along = node / stride % 8;
        if along != if onward { 7 } else { 0 } {
            return Some(if onward { node + stride } else { node - stride });
        }
        let block = self.beside[node / BLOCK_VOXELS][face];
        let place = node % BLOCK_VOXELS;
        let place = if onward { place - 7 * stride } else { place + 7 * stride };
        (block != NONE).then_some(block as usize * BLOCK_VOXELS + place)
    }

    /// Where a node is.
    pub fn voxel(&self, node: usize) -> IVec3 {
        let place = node as i32 % BLOCK_VOXELS as i32;
        self.origins[node / BLOCK_VOXELS] + IVec3::new(place >> 6, place >> 3 & 7, place & 7)
    }

    /// The number of the node that is there.
    pub fn node(&self, voxel: IVec3) -> Option<usize> {
        let block = place_of(&self.origins, block_origin(voxel)).ok()?;
        Some(block * BLOCK_VOXELS + voxel_offset(voxel))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_those_of_the_voxels() {
        let blocks = Blocks::filling(IVec3::new(-9, 0, 3), IVec3::new(8, 7, 12));
        assert_eq!(blocks.nodes(), 4 * 2 * 512);
        assert_eq!(blocks.ends(), (IVec3::new(-16, 0, 0), IVec3::new(15, 7, 15)));
        for node in 0..blocks.nodes() {
            let voxel = blocks.voxel(node);
            assert_eq!(blocks.node(voxel), Some(node));
            for face in 0..6 {
                let step = IVec3::AXES[face / 2] * if face % 2 == 0 { -1 } else { 1 };
                assert_eq!(blocks.beside(node, face), blocks.node(voxel + step), "{voxel} {face}");
            }
        }
    }
}
