//! Why frames are not baked.

use std::fmt;

use super::Bytes;
use super::asked::ComputeError;
use super::frame::{OF_THIN, rounded};
use crate::distance::band;
use crate::{disk, shot};

/// Why a frame, or all of them, could not be baked.
#[derive(Debug)]
pub enum Error {
    /// The scene gives no such frame.
    Scene(shot::Error),
    /// A frame could not be computed.
    Frame(i64, ComputeError),
    /// A frame of which no voxel is inside, though it has a surface.
    Hollow {
        /// The frame.
        frame: i64,
        /// The voxel size that it needs, about, world units.
        enough: Option<f64>,
    },
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
            Self::Scene(_)
            | Self::Frame(..)
            | Self::Hollow { .. }
            | Self::Encode(_)
            | Self::Disk(disk::Error::Exists { .. }) => true,
            Self::Disk(_) | Self::Memory { .. } | Self::Interrupted => false,
        }
    }
}

impl Error {
    /// Whether the frame has no surface, which `--allow-empty` allows.
    pub fn is_empty_frame(&self) -> bool {
        let is_empty = |error: &_| matches!(error, ComputeError::Distance(band::Error::Empty { solid: false }));
        matches!(self, Self::Frame(_, error) if is_empty(error)) || matches!(self, Self::Hollow { .. })
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
            Self::Hollow { frame, enough } => {
                write!(f, "frame {frame} is empty: all of it is thinner than a voxel, so that nothing is inside; ")?;
                match enough {
                    Some(size) => write!(f, "voxels of {} hold it", rounded(*size, OF_THIN))?,
                    None => f.write_str("smaller voxels hold it")?,
                }
                f.write_str("; --allow-empty writes a valid empty file")
            }
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
