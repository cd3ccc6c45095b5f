//! Bands of exact distances for tests, found the slow and obvious way.

use glam::{DVec3, IVec3};

use super::{BLOCK_EDGE, BLOCK_VOXELS, Band, InsideTile, Lattice, VoxelSize, block_order};

/// The index position of a block's voxel.
pub(crate) fn voxel_of(origin: IVec3, offset: usize) -> IVec3 {
    origin + IVec3::new((offset / 64) as i32, (offset / 8 % 8) as i32, (offset % 8) as i32)
}

/// The band, of half width 3, of any distance function (positive inside) over a cube of ± `reach` world units, with
/// inside tiles of a block's size; found by looking at the centre of every block in it.
pub(crate) fn band_of(distance: impl Fn(DVec3) -> f64, reach: f64, voxel_size: f64) -> Band {
    let lattice = Lattice { voxel_size: VoxelSize::new(voxel_size).unwrap() };
    let half_width = 3.0;
    let limit = f64::from(half_width) * voxel_size;
    let blocks = (reach / voxel_size / 8.0).ceil() as i32 + 1;
    let mut origins = Vec::new();
    let mut inside_tiles = Vec::new();
    for x in -blocks..blocks {
        for y in -blocks..blocks {
            for z in -blocks..blocks {
                let origin = IVec3::new(x, y, z) * BLOCK_EDGE;
                let centre = distance((origin.as_dvec3() + 3.5) * voxel_size);
                // The farthest voxel of a block is 3.5·√3 voxels from its centre.
                if centre.abs() < limit + 6.1 * voxel_size {
                    origins.push(origin);
                } else if centre > 0.0 {
                    inside_tiles.push(InsideTile { origin, edge: BLOCK_EDGE });
                }
            }
        }
    }
    origins.sort_by_key(|&origin| block_order(origin));
    inside_tiles.sort_by_key(|tile| block_order(tile.origin));
    let clamped = |voxel: IVec3| distance(lattice.centre(voxel)).clamp(-limit, limit) as f32;
    let distances: Vec<[f32; BLOCK_VOXELS]> =
        origins.iter().map(|&origin| std::array::from_fn(|offset| clamped(voxel_of(origin, offset)))).collect();
    let active = distances
        .iter()
        .map(|block| {
            let near = |offset: usize| u64::from(block[offset].abs() < limit as f32);
            std::array::from_fn(|x| (0..64).fold(0, |word, bit| word | near(x * 64 + bit) << bit))
        })
        .collect();
    Band { lattice, half_width, origins, distances, active, inside_tiles }
}

/// The band of a sphere.
pub(crate) fn sphere(centre: DVec3, radius: f64, voxel_size: f64) -> Band {
    let reach = centre.abs().max_element() + radius + 4.0 * voxel_size;
    band_of(|p| radius - (p - centre).length(), reach, voxel_size)
}
