//! Coloured volumetric objects, modelled by functions, morphed through space and time, written as OpenVDB.
//!
//! # Conventions
//!
//! * **Sign.** Every field in this crate is **positive inside** (F ≥ 0 is the solid). An OpenVDB level set is
//!   negative inside; the one place that flips the sign is [`vdb`], on write and on read.
//! * **Units.** Fields take and return world units; lengths in voxels say so in their name.
//! * **Positions.** World positions are [`glam::DVec3`], voxel (index) positions are [`glam::IVec3`], a voxel's
//!   edge is a [`grid::VoxelSize`]. Batches hold an `f64` origin and small `f32` offsets ([`field::Points`]), so
//!   that a surface far from the world's origin keeps its accuracy.
//! * **Time.** A scene's frames map to t in \[0, 1\]; nothing below the `shot` room knows frames.
//!
//! # Layers
//!
//! `cli → bake, render → shot → node → text; node → morph, attribute → distance, mesh → field, grid`; `vdb → grid`. An arrow never points
//! the other way. Whatever reads or writes files uses `disk`, whatever prints text of others `terminal`.

pub mod attribute;
pub mod bake;
#[cfg(feature = "cli")]
pub mod cli;
pub mod disk;
pub mod distance;
pub mod field;
pub mod grid;
pub mod mesh;
pub mod morph;
pub mod node;
pub mod render;
pub mod shot;
pub mod terminal;
pub mod text;
pub mod vdb;
