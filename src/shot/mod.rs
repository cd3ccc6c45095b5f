//! Frames made from nodes: the shot's box and lattice, morphs planned over it, what is kept from frame to frame, and each
//! frame's field, colours, scalars and motion. Knows no voxels, and writes no files.

mod carry;
mod delay;
mod drawn;
mod error;
mod far;
mod level_sets;
mod matching;
mod morph_paint;
mod morph_settings;
mod morphing;
mod movement;
mod placed;
mod plane;
mod prepare;
mod prepared;
mod scenery;
mod stop;

#[cfg(test)]
mod carry_tests;
#[cfg(test)]
mod conformal_tests;
#[cfg(test)]
mod delay_tests;
#[cfg(test)]
mod displace_tests;
#[cfg(test)]
mod distance_tests;
#[cfg(test)]
mod distance_trees;
#[cfg(test)]
mod far_tests;
#[cfg(test)]
mod frame_tests;
#[cfg(test)]
mod keep_tests;
#[cfg(test)]
mod level_set_tests;
#[cfg(test)]
mod method_tests;
#[cfg(test)]
mod mode_tests;
#[cfg(test)]
mod morphed_tests;
#[cfg(test)]
mod pairs_tests;
#[cfg(test)]
mod partition_tests;
#[cfg(test)]
mod plane_tests;
#[cfg(test)]
mod ready_tests;
#[cfg(test)]
mod scalar_tests;
#[cfg(test)]
mod sequence_tests;
#[cfg(test)]
mod volume_tests;

pub use drawn::{Drawn, InPlane};
pub use error::Error;
pub use prepare::PrepareOptions;
pub use prepared::{FrameContent, FrameInfo, MorphReport, Prepared};
