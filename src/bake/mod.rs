//! The job: which frames, within which memory, into which files; progress, interruption, errors.
//!
//! Turns a prepared scene into files, frame by frame; knows no geometry of its own.

mod compute;
mod frames;
mod interrupt;
mod memory;
mod pattern;
mod run;
mod target;

pub use compute::{ComputeError, Computed, compute};
pub use frames::{Frames, FramesError};
pub use interrupt::Interrupt;
pub use memory::{Bytes, default_limit};
pub use pattern::{FramePattern, PatternError};
pub use run::{Error, Estimate, Event, Output, Record, bake, check_memory, compute_frame, estimate};
pub use target::{OutputFolder, TargetError, make_ready};
