//! Nodes: everything that a scene can name, from its text to its field, colours and scalars at one moment.
//!
//! [`load`] checks a scene's text against [`keys`] into a [`Model`]. Knows no frames, no voxels, and writes no files.

pub(crate) mod argument;
pub(crate) mod assets;
pub(crate) mod attributes;
pub(crate) mod bend;
mod color;
mod combine;
mod copies;
pub(crate) mod depth;
pub(crate) mod displacement;
mod example;
pub(crate) mod extent;
mod hash;
pub(crate) mod id;
mod import;
pub mod keys;
pub(crate) mod list;
pub(crate) mod load;
pub(crate) mod measured;
pub(crate) mod model;
mod number;
pub(crate) mod paint;
pub(crate) mod placed;
mod primitive;
mod read;
mod reference;
pub(crate) mod solid;
pub(crate) mod source;
pub(crate) mod space;
pub(crate) mod spec;
mod structure;
mod surface;
pub(crate) mod variation;
mod volume;

#[cfg(test)]
mod row_tests;
#[cfg(test)]
mod tests;

pub use example::{node_names, node_scene};
pub use load::{Source, load, morph_of_meshes};
pub use model::*;
pub use reference::reference;
