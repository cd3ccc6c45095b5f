//! Sparse voxel storage: the lattice, 8³ leaf blocks, the band around a surface.
//!
//! Knows no fields, no files and no OpenVDB; [`crate::distance`] fills what is here and [`crate::vdb`] stores it.

use glam::IVec3;

mod band;
mod lattice;
pub mod mask;
pub mod measure;
#[cfg(test)]
pub(crate) mod testing;

pub use band::{Band, Channel, InsideTile};
pub use lattice::{Lattice, VoxelSize, block_order, block_origin, node_origin, place_of, voxel_offset};

/// Voxels along one edge of a leaf block.
pub const BLOCK_EDGE: i32 = 8;
/// Voxels in a leaf block; a voxel's place is `x·64 + y·8 + z` of its offsets in the block ([`voxel_offset`]).
pub const BLOCK_VOXELS: usize = 512;
/// Active flags of a block: word `x`, bit `y·8 + z`.
pub type BlockMask = [u64; 8];

/// The steps to the voxels, or blocks, that share a face.
pub(crate) const FACES: [IVec3; 6] = [IVec3::X, IVec3::Y, IVec3::Z, IVec3::NEG_X, IVec3::NEG_Y, IVec3::NEG_Z];

/// Whether the voxel at a place in its block ([`voxel_offset`]) is active.
pub fn is_active(mask: &BlockMask, offset: usize) -> bool {
    mask[offset >> 6] >> (offset & 63) & 1 == 1
}
