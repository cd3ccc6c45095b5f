//! Coloured volumetric objects, modelled by functions, morphed through space and time, written as OpenVDB.
//!
//! # From a scene to a frame
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use std::sync::Arc;
//!
//! use glam::DVec3;
//! use hfvdb::node::{Source, load};
//! use hfvdb::shot::PrepareOptions;
//! use hfvdb::text::Overrides;
//!
//! // A scene: a file, a built-in name, or text.
//! let text = "hfvdb = 1\n[shape.ball]\nsphere = 1\ncolor = \"tomato\"\n";
//! let source = Source::Text { name: "ball.toml".into(), text: text.into(), folder: ".".into() };
//! let model = Arc::new(load(&source, &Overrides::default()).map_err(|problems| problems.to_string())?);
//!
//! // Made ready: the shot's box, the lattice, and for a morph the measured objects.
//! let prepared = model.prepare(&PrepareOptions { resolution: Some(32), ..PrepareOptions::default() })?;
//!
//! // A frame: F and colour at any point, any frame by itself.
//! let frame = prepared.frame(1)?;
//! assert_eq!(frame.field.reference(DVec3::ZERO), 1.0);
//! assert!(frame.colour.is_some());
//! # Ok(())
//! # }
//! ```
//!
//! A program can make the scene without text, by [`node::Scene`]. [`bake::compute_frame`] makes voxels of a frame, [`vdb::write`] a file; `examples/sphere.rs` does both,
//! `examples/morph.rs` follows a morph. [`node`] has the table of all that a scene can name; `docs/adding-a-node.md` adds to
//! it.
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
//! # Glossary
//!
//! * **Field**, F: a number at any point, positive inside; its bounds over a box, its gradient ([`field::Field`]).
//! * **Distance**: a field whose value is the signed distance to its surface ([`distance::Distance`]), found by a **method**
//!   ([`distance::method`]); where the method knows it, with the **closest point**, called foot in the code.
//! * **Node**: what a scene can name. A **primitive** is a shape by itself, an **operator** joins shapes, a **modifier**
//!   changes one; sources give colours and numbers. Each is a row of one table.
//! * **Attribute**: a colour or a number at any point of an object ([`attribute::Attribute`]), in the file a grid of its own.
//! * **Object**: a distance with its attributes in its own space, and its motion ([`morph::MorphObject`]).
//! * **Morph**: two objects and what lies between them at each time ([`morph::Morph`]). Its **pace** keeps the change of
//!   every frame alike; its **carry** takes objects that lie apart along one way; a **section** is the shape at one time of
//!   the blend in space-time.
//! * **Block**: 8³ voxels, OpenVDB's leaf. **Band**: the blocks around the surface, so many voxels to either side
//!   (**half width**) ([`grid::Band`]). **Tile**: a block, or more, of one value.
//! * **Shot**: a scene's frames, their box and lattice ([`shot`]). **Frame**: what becomes one file.
//!
//! # Layers
//!
//! `cli → bake, render → shot → node → text; node → morph, attribute → distance, mesh → field, grid`; `node → lettering, svg → field → raster`; `vdb → grid`. An arrow never points
//! the other way. Whatever reads or writes files uses `disk`, whatever prints text of others `terminal`.

pub mod attribute;
pub mod bake;
// What `main.rs` calls, and nobody else.
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
pub mod disk;
pub mod distance;
pub mod field;
pub mod grid;
mod lettering;
pub mod mesh;
pub mod morph;
pub mod node;
mod raster;
pub mod render;
pub mod shot;
mod svg;
mod terminal;
pub mod text;
pub mod vdb;
