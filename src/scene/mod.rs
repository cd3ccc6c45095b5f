//! The scene format: text with places, checked into a model with names resolved, and frames made from it.
//!
//! The way: [`load`] reads TOML or JSON into a tree of values that know their places, applies overrides, and
//! checks it against [`keys`] into a [`Model`]. Knows no voxels and writes no files.

mod assets;
mod builtin;
mod colour;
mod delay;
mod depth;
mod diagnostic;
mod displace;
mod error;
mod files;
mod formula;
mod frames;
mod hash;
mod keyed;
pub mod keys;
mod level_sets;
mod load;
mod measured;
mod model;
mod morph_paint;
mod morph_settings;
mod morphing;
mod movement;
mod number;
mod overrides;
mod paint;
mod placed;
mod prepare;
mod prepared;
mod read;
mod reader;
mod reference;
mod solid;
mod source;
mod value;
mod variation;
mod volume;

#[cfg(test)]
mod delay_tests;
#[cfg(test)]
mod displace_tests;
#[cfg(test)]
mod distance_tests;
#[cfg(test)]
mod distance_trees;
#[cfg(test)]
mod frame_tests;
#[cfg(test)]
mod level_set_tests;
#[cfg(test)]
mod partition_tests;
#[cfg(test)]
mod ready_tests;
#[cfg(test)]
mod scalar_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod volume_tests;

pub use builtin::{builtin_line, builtin_names, builtin_text};
pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use error::Error;
pub use files::{FilePlace, FileReference, expand};
pub use formula::Formula;
pub use frames::{BadRange, FrameRange, Shot};
pub use keyed::{Ease, Key, Keys};
pub use load::{Source, load, morph_of_meshes};
pub use model::*;
pub use number::{BadNumber, Moment, Number, NumberValue};
pub use overrides::Overrides;
pub use prepare::PrepareOptions;
pub use prepared::{FrameContent, FrameInfo, MorphReport, Prepared};
pub use reader::Setting;
pub use reference::reference;
pub use source::{Place, Span};
pub use value::Origin;
