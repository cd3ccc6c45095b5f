//! What can go wrong at the border, with what to do about it.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use crate::disk;
use crate::terminal;

/// An error of this room.
#[derive(Debug)]
pub enum Error {
    /// A grid that cannot be stored as it was given: the caller's input.
    Grid {
        /// The grid's name.
        grid: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The system refused, or there is a file of that name and the options do not allow to replace it.
    Disk(disk::Error),
    /// A file is not whole, or not what it says it is.
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where in the file, in bytes from its start.
        offset: u64,
        /// What is wrong there.
        problem: String,
    },
    /// A sound file that holds something that is not read here.
    Unsupported {
        /// The file.
        path: PathBuf,
        /// What is not supported.
        problem: String,
    },
    /// OpenVDB failed on a file.
    File {
        /// The file.
        path: PathBuf,
        /// OpenVDB's message.
        message: String,
    },
    /// OpenVDB failed away from any file.
    Library {
        /// OpenVDB's message.
        message: String,
    },
}

impl Error {
    pub(super) fn grid(grid: &str, problem: impl Into<String>) -> Self {
        Self::Grid { grid: grid.into(), problem: problem.into() }
    }

    pub(super) fn system(path: &Path, action: &'static str, source: io::Error) -> Self {
        Self::Disk(disk::Error::system(path, action, source))
    }
}

impl From<disk::Error> for Error {
    fn from(error: disk::Error) -> Self {
        Self::Disk(error)
    }
}

/// Characters of a problem that are shown: names of grids are as long as a file says.
const LONGEST: usize = 400;

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Grid { grid, problem } => write!(f, "grid '{grid}': {problem}"),
            Self::Disk(error) => error.fmt(f),
            Self::Damaged { path, offset, problem } => {
                let (path, problem) = (terminal::path(path), terminal::clipped(problem, LONGEST));
                write!(f, "{path}: damaged at byte {offset}: {problem}: write or fetch it again")
            }
            Self::Unsupported { path, problem } => {
                write!(f, "{}: {}", terminal::path(path), terminal::clipped(problem, LONGEST))
            }
            Self::File { path, message } => {
                write!(f, "{}: OpenVDB: {}", terminal::path(path), terminal::clipped(message, LONGEST))
            }
            Self::Library { message } => write!(f, "OpenVDB: {message}"),
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Disk(error) => error.source(),
            _ => None,
        }
    }
}
