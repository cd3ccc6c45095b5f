//! What the benches compare with, in C++.

#![allow(unsafe_code, missing_docs, unused_qualifications)]

#[cxx::bridge(namespace = "rivals")]
mod ffi {
    unsafe extern "C++" {
        include!("rivals.h");

        /// Makes, links and encodes leaves in C++ alone; returns the bytes.
        fn encode_in_cpp(
            origins: &[i32],
            masks: &[u64],
            values: &[f32],
            background: f32,
            threads: usize,
            seconds: &mut [f64; 2],
        ) -> Result<usize>;

        type LibraryFrame;
        fn read_with_library(path: &str) -> Result<UniquePtr<LibraryFrame>>;
        fn write(self: &LibraryFrame, path: &str) -> Result<()>;

        type VoxelTree;
        fn new_voxel_tree(background: f32) -> Result<UniquePtr<VoxelTree>>;
        fn set(self: Pin<&mut VoxelTree>, x: i32, y: i32, z: i32, value: f32) -> Result<()>;
        fn encode(self: &VoxelTree) -> Result<usize>;

        type RivalGrid;
        fn active_voxels(self: &RivalGrid) -> u64;
        fn leaves(self: &RivalGrid) -> usize;
        fn blocks(self: &RivalGrid, origins: &mut [i32], masks: &mut [u64], values: &mut [f32]);
        fn dense_grid(origins: &[i32], values: &[f32], voxel_size: f64) -> Result<UniquePtr<RivalGrid>>;
        fn accessor_loop(balls: &[f64], holes: &[f64], resolution: i32, threads: usize)
        -> Result<UniquePtr<RivalGrid>>;
        fn spheres_by_csg(balls: &[f64], holes: &[f64], voxel_size: f64) -> Result<UniquePtr<RivalGrid>>;
        fn rebuild(dense: &RivalGrid) -> Result<UniquePtr<RivalGrid>>;
        fn sweep(dense: &RivalGrid) -> Result<UniquePtr<RivalGrid>>;
        fn sphere_level_set(radius: f64, voxel_size: f64) -> Result<UniquePtr<RivalGrid>>;
        fn cube_level_set(edge: f64, voxel_size: f64) -> Result<UniquePtr<RivalGrid>>;
        type ColouredGrid;
        fn active_voxels(self: &ColouredGrid) -> u64;
        fn value(self: &ColouredGrid, x: i32, y: i32, z: i32) -> f32;
        fn mesh_to_volume(
            positions: &[f32],
            triangles: &[u32],
            colours: &[f32],
            voxel_size: f64,
        ) -> Result<UniquePtr<ColouredGrid>>;
        fn read_coloured(path: &str) -> Result<UniquePtr<ColouredGrid>>;
        fn volume_to_mesh(grid: &ColouredGrid, adaptivity: f64) -> Result<usize>;
        fn morph(source: Pin<&mut RivalGrid>, target: &RivalGrid, from: f64, to: f64) -> Result<usize>;
    }
}

use glam::IVec3;

use hfvdb::grid::{BLOCK_VOXELS, Band, BlockMask, Lattice};

pub use ffi::{
    ColouredGrid, LibraryFrame, RivalGrid, VoxelTree, accessor_loop, cube_level_set, dense_grid, encode_in_cpp,
    mesh_to_volume, morph, new_voxel_tree, read_coloured, read_with_library, rebuild, sphere_level_set, spheres_by_csg,
    sweep, volume_to_mesh,
};

/// A rival's level set as a band, positive inside: active where it is within `half_width` voxels, and limited there.
pub fn band_of(grid: &RivalGrid, lattice: Lattice, half_width: f32) -> Band {
    let leaves = grid.leaves();
    let mut origins = vec![0; 3 * leaves];
    let mut active: Vec<BlockMask> = vec![[0; 8]; leaves];
    let mut distances = vec![[0.0; BLOCK_VOXELS]; leaves];
    grid.blocks(&mut origins, active.as_flattened_mut(), distances.as_flattened_mut());
    let background = (f64::from(half_width) * lattice.voxel_size.get()) as f32;
    for (mask, values) in active.iter_mut().zip(&mut distances) {
        for (place, value) in values.iter_mut().enumerate() {
            let within = value.abs() < background;
            mask[place >> 6] &= !(u64::from(!within) << (place & 63));
            *value = (-*value).clamp(-background, background);
        }
    }
    let origins = origins.chunks_exact(3).map(IVec3::from_slice).collect();
    Band { lattice, half_width, origins, distances, active, inside_tiles: Vec::new() }
}
