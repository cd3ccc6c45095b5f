//! The voxels of a grid from a file, as blocks and tiles.

use glam::IVec3;

use crate::grid::{BLOCK_VOXELS, BlockMask};

/// The voxels of a grid from a file. Numbers of 64 bits are rounded to 32.
#[derive(Clone, Debug)]
pub enum Voxels {
    /// One number a voxel; of a level set, the distance, **positive inside**.
    Floats(SparseBlocks<f32>),
    /// Three numbers a voxel.
    Vectors(SparseBlocks<[f32; 3]>),
}

/// Blocks, tiles, and the value away from both.
#[derive(Clone, Debug)]
pub struct SparseBlocks<T> {
    /// The blocks' least corners, sorted by [`crate::grid::block_order`].
    pub origins: Vec<IVec3>,
    /// One array a block.
    pub values: Vec<[T; BLOCK_VOXELS]>,
    /// Active voxels.
    pub active: Vec<BlockMask>,
    /// Cubes of one value: those that are active, and those that differ from the background.
    pub tiles: Vec<Tile<T>>,
    /// The value away from blocks and tiles; of a level set negative, as everything outside.
    pub background: T,
}

/// A cube of voxels that have one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tile<T> {
    /// Its least corner, a multiple of `edge`.
    pub origin: IVec3,
    /// Its edge in voxels: 8, 128 or 4096.
    pub edge: i32,
    /// The value of all its voxels.
    pub value: T,
    /// Whether they are active.
    pub active: bool,
}
