//! What the benches compare the border with: the feature `rivals`, never part of the program.

#![allow(unsafe_code, missing_docs, unused_qualifications)]

#[cxx::bridge(namespace = "hfvdb")]
mod ffi {
    unsafe extern "C++" {
        include!("rivals.h");

        /// Makes and links leaves in C++ alone; returns the tree's active voxels.
        fn link_in_cpp(
            origins: &[i32],
            masks: &[u64],
            values: &[f32],
            background: f32,
            threads: usize,
            seconds: &mut f64,
        ) -> Result<u64>;

        type VoxelTree;
        fn new_voxel_tree(background: f32) -> Result<UniquePtr<VoxelTree>>;
        fn set(self: Pin<&mut VoxelTree>, x: i32, y: i32, z: i32, value: f32) -> Result<()>;
        fn active_voxels(self: &VoxelTree) -> u64;
    }
}

pub use ffi::{VoxelTree, link_in_cpp, new_voxel_tree};
