//! What is active of voxels that were read.

use std::collections::{HashMap, HashSet};

use glam::IVec3;

use super::voxels::SparseBlocks;
use crate::grid::{BLOCK_EDGE, block_origin, is_active, node_origin};

/// The values of active voxels, and of active tiles.
pub(super) fn active_values<T: Copy>(blocks: &SparseBlocks<T>) -> impl Iterator<Item = T> {
    let in_block = |(values, mask)| {
        let values: &[T; 512] = values;
        values.iter().enumerate().filter(move |(offset, _)| is_active(mask, *offset)).map(|(_, value)| *value)
    };
    let in_tiles = blocks.tiles.iter().filter(|tile| tile.active).map(|tile| tile.value);
    blocks.values.iter().zip(&blocks.active).flat_map(in_block).chain(in_tiles)
}

/// How many active voxels of the one are not active in the other, those of tiles left out.
pub(super) fn missing_voxels(surface: &SparseBlocks<f32>, colours: &SparseBlocks<[f32; 3]>) -> u64 {
    let blocks: HashMap<IVec3, usize> = colours.origins.iter().enumerate().map(|(i, origin)| (*origin, i)).collect();
    let tiles: HashSet<(IVec3, i32)> =
        colours.tiles.iter().filter(|tile| tile.active).map(|tile| (tile.origin, tile.edge)).collect();
    let missing = |(origin, mask): (&IVec3, &[u64; 8])| -> u64 {
        let in_tile = |edge: i32| tiles.contains(&(node_origin(*origin, edge), edge));
        if [BLOCK_EDGE, 128, 4096].into_iter().any(in_tile) {
            return 0;
        }
        let other = blocks.get(&block_origin(*origin)).map_or([0; 8], |block| colours.active[*block]);
        mask.iter().zip(other).map(|(own, other)| u64::from((own & !other).count_ones())).sum()
    };
    surface.origins.iter().zip(&surface.active).map(missing).sum()
}
