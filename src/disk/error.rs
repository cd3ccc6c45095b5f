//! What the system can refuse, with what to do about it.

use crate::terminal;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// An error of this room.
#[derive(Debug)]
pub enum Error {
    /// There is a file of that name, and it shall not be replaced.
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// The system refused.
    System {
        /// The file or folder.
        path: PathBuf,
        /// What was tried, as in "cannot `action`".
        action: &'static str,
        /// The system's answer.
        source: io::Error,
    },
    /// The disk does not hold what was written.
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where in the file, in bytes from its start.
        offset: u64,
        /// What is wrong there.
        problem: String,
    },
}

impl Error {
    /// The system's refusal of `action` on a path.
    pub fn system(path: &Path, action: &'static str, source: io::Error) -> Self {
        Self::System { path: path.into(), action, source }
    }
}

/// What to do about a system's answer.
fn advice(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::StorageFull => ": make room on that disk, or write elsewhere",
        io::ErrorKind::QuotaExceeded => ": free some of your quota, or write elsewhere",
        io::ErrorKind::ReadOnlyFilesystem => ": that file system is read-only, write elsewhere",
        io::ErrorKind::PermissionDenied => ": ask for the permission, or choose another folder",
        io::ErrorKind::NotFound => ": check the path, and make its folder first",
        io::ErrorKind::NotADirectory => ": a part of the path is a file, choose another folder",
        io::ErrorKind::IsADirectory => ": that is a folder, name a file",
        io::ErrorKind::FileTooLarge => ": larger than that file system or your limits allow",
        io::ErrorKind::InvalidFilename => ": choose a shorter name",
        _ => "",
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exists { path } => {
                write!(f, "{} exists: allow to overwrite it, or choose another name", terminal::path(path))
            }
            Self::System { path, action, source } => {
                write!(f, "{}: cannot {action}: {source}{}", terminal::path(path), advice(source))
            }
            Self::Damaged { path, offset, problem } => {
                write!(f, "{}: damaged at byte {offset}: {problem}: write it again", terminal::path(path))
            }
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Exists { .. } | Self::Damaged { .. } => None,
            Self::System { source, .. } => Some(source),
        }
    }
}
