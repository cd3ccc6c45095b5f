//! Why frames are not baked.

use std::fmt;

use super::Bytes;
use super::asked::ComputeError;
use crate::distance::band;
use crate::{disk, shot};

/// Why a frame, or all of them, could not be baked.
#[derive(Debug)]
pub enum Error {
    /// The scene gives no such frame.
    Scene(shot::Error),
    /// A frame could not be computed.
    Frame(i64, ComputeError),
    /// A frame is nothing that its format can hold: in words.
    Encode(String),
    /// A file could not be written.
    Disk(disk::Error),
    /// More memory would be needed than allowed.
    Memory {
        /// About what is needed.
        needed: Bytes,
        /// What is allowed.
        limit: Bytes,
        /// About how many active voxels.
        voxels: f64,
    },
    /// The caller raised the [`Interrupt`](super::Interrupt).
    Interrupted,
}

impl Error {
    /// Whether it is the frame's own, so that other frames may still succeed. A full disk, a lack of memory or a signal
    /// are everybody's.
    pub fn is_of_frame(&self) -> bool {
        match self {
            Self::Scene(_) | Self::Frame(..) | Self::Encode(_) | Self::Disk(disk::Error::Exists { .. }) => true,
            Self::Disk(_) | Self::Memory { .. } | Self::Interrupted => false,
        }
    }
}

impl Error {
    /// Whether the frame has no surface, which `--allow-empty` allows.
    pub fn is_empty_frame(&self) -> bool {
        matches!(self, Self::Frame(_, ComputeError::Distance(band::Error::Empty { solid: false })))
    }
}

impl From<disk::Error> for Error {
    fn from(error: disk::Error) -> Self {
        Self::Disk(error)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scene(error) => error.fmt(f),
            Self::Frame(frame, ComputeError::Distance(error @ band::Error::Empty { .. })) => {
                write!(f, "frame {frame} is empty: {error}; --allow-empty writes a valid empty file")
            }
            Self::Frame(frame, error) => write!(f, "frame {frame}: {error}"),
            Self::Encode(problem) => f.write_str(problem),
            Self::Disk(error) => error.fmt(f),
            Self::Memory { needed, limit, voxels } => write!(
                f,
                "about {voxels:.2e} voxels would take about {needed} of memory, and the limit is {limit}; \
                 take a larger voxel size or a smaller --resolution, or raise the limit with --max-memory"
            ),
            Self::Interrupted => f.write_str("interrupted"),
        }
    }
}

impl std::error::Error for Error {}
