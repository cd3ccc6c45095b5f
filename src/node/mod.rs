//! Nodes: everything that a scene can name, from its text to its field, colours and scalars at one moment.
//!
//! [`load`] checks a scene's text against [`keys`] into a [`Model`]. Knows no frames, no voxels, and writes no files.

pub(crate) mod assets;
pub(crate) mod depth;
pub(crate) mod displace;
pub(crate) mod extent;
mod hash;
pub mod keys;
pub(crate) mod load;
pub(crate) mod measured;
pub(crate) mod model;
pub(crate) mod paint;
pub(crate) mod placed;
mod read;
mod reference;
pub(crate) mod solid;
pub(crate) mod variation;
mod volume;

#[cfg(test)]
mod tests;

pub use load::{Source, load, morph_of_meshes};
pub use model::*;
pub use reference::reference;
