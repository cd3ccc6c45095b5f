//! The job: which frames, within which memory, into which files; progress, interruption, errors; what was done before,
//! and what came of it.
//!
//! Turns a prepared scene into files, frame by frame; knows no geometry of its own. Each frame that was written has a
//! [`Record`]; the records of a [`Sequence`] make its [`Manifest`].

mod asked;
mod claim;
mod compute;
mod done;
mod error;
mod estimate;
mod frame;
mod frames;
mod identity;
mod inside;
mod interrupt;
mod manifest;
mod memory;
mod memory_limit;
pub mod output;
mod probe;
mod range;
mod record;
mod refusal;
mod run;
mod sealed;
mod sequence;
mod survey;
mod target;
mod usd_layer;
mod velocity;
mod verify;
mod whole;
mod wish;

pub use crate::text::{FramePattern, PatternError};
pub use asked::{Attributes, ComputeError, Interior};
pub use claim::Claim;
pub use compute::{Computed, Distances, Ranges, compute};
pub use done::{State, judge_all};
pub use error::Error;
pub use estimate::{Estimate, check_memory, estimate, in_flight};
pub use frame::{compute_frame, empty, rounded};
pub use frames::{Frames, FramesError};
pub use identity::{Identity, Sampling};
pub use inside::{Inside, Insides};
pub use interrupt::Interrupt;
pub use manifest::{Entry, Known, Manifest, Source};
pub use memory::Bytes;
pub use memory_limit::default_limit;
pub use probe::{Probe, probe};
pub use range::Range;
pub use record::{Beyond, GridRecord, PolygonRecord, Record};
pub use refusal::{Refusal, refusal};
pub use run::{Baked, Event, Existing, Output, bake};
pub use sealed::SealedError;
pub use sequence::Sequence;
pub use target::{OutputFolder, TargetError, check_place, make_ready};
pub use usd_layer::{FrameFile, Layer, LayerOptions, usd_layer};
pub use velocity::Velocities;
pub use verify::{Finding, Verdict, sequences, verify};
pub use whole::{Whole, WholeLock};
pub use wish::Wish;
