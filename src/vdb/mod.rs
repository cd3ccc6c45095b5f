//! The OpenVDB border: the one room that knows OpenVDB exists, and the one place that flips the sign.
//!
//! Everywhere else a field is positive inside; a level set in a file is negative inside. Grids made here from a
//! [`crate::grid::Band`] are flipped on their way out, and level sets that are read are flipped on their way in.
//!
//! OpenVDB helps to write files and morphs level sets; it reads none. What others wrote is parsed and decoded in Rust, where
//! damage is an error and never a crash.
//!
//! * [`write()`] makes one file of a [`Frame`]: encoded on all threads, written under a temporary name, checked, synced
//!   to the disk and renamed, so that a file with a final name is always whole.
//! * [`encode()`] gives the bytes alone, and [`read_back`] walks them; [`encode_nano`] those of NanoVDB.
//! * [`walk::walk`] parses a whole file in safe Rust and checks every length in it; it stands before every reading.
//! * [`LevelSet`] runs OpenVDB's own morph of one level set into another.
//! * [`inspect()`] says what is in a file, [`lint()`] what is wrong with it, [`read()`] gives its blocks, decoded on all
//!   threads.
//!
//! Files written here are of format 224, with OpenVDB's statistics. Two writes of one frame differ only in bytes 21 to 56, where
//! OpenVDB keeps a random identifier.
//!
//! No field, no scene and no picture is known here.

mod active;
mod blosc;
mod bridge;
mod clients;
mod decode;
mod encode;
mod error;
mod finding;
mod frame;
mod inspect;
mod level_set;
mod lint;
mod metadata;
mod nano;
mod programs;
mod read;
mod voxels;
pub mod walk;
mod write;

pub use clients::VELOCITIES;
pub use encode::encode;
pub use error::Error;
pub use finding::{Finding, Severity};
pub use frame::{Blocks, Class, Content, Frame, Grid, Tiles, Values, VectorType};
pub use inspect::{FileInfo, GridInfo, Range, inspect, level_set_box};
pub use level_set::LevelSet;
pub use lint::{Lint, lint};
pub use metadata::{INTEROP_ID, Metadata, MetadataValue, metadata_text};
pub use nano::{encode_nano, read_back_nano};
pub use programs::{Client, NAMES as PROGRAM_NAMES, Program, Three};
pub use read::{Contents, Opened, StoredClass, StoredGrid, read};
pub use voxels::{SparseBlocks, Tile, Voxels};
pub use walk::{Transform, read_back};
pub use write::{Compression, WriteOptions, write};

/// The version of the OpenVDB library in use, such as `10.0.1`.
pub fn library_version() -> String {
    bridge::ffi::library_version()
}

/// Lets OpenVDB work on at most so many threads (at least one) in this process, from now on.
///
/// # Errors
/// When its thread pool refuses.
pub fn set_threads(threads: usize) -> Result<(), Error> {
    bridge::ffi::set_thread_limit(threads.max(1)).map_err(|error| Error::Library { message: error.what().into() })
}

/// F is positive inside everywhere else, a level set of OpenVDB is negative inside. A zero becomes +0.
#[inline]
fn flip_sign(value: f32) -> f32 {
    0.0 - value
}

#[cfg(test)]
mod tests;
