//! Where the files go: checked before any work is done.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use super::FramePattern;

/// Why files cannot go where they should.
#[derive(Debug)]
pub enum TargetError {
    /// The parent of the output folder is not there.
    NoParent(PathBuf),
    /// Something else stands where the output folder should be, or it cannot be made.
    Folder(PathBuf, io::Error),
    /// Files that exist, the first of them named.
    Exist(PathBuf, usize),
}

impl fmt::Display for TargetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoParent(path) => write!(
                f,
                "{}: the folder {} does not exist; only the last folder of a path is made, make the others first",
                path.display(),
                path.parent().unwrap_or(path).display()
            ),
            Self::Folder(path, error) => {
                write!(f, "{}: cannot write into this folder: {error}; choose another with -o", path.display())
            }
            Self::Exist(path, 1) => {
                write!(f, "{} exists; replace it with --overwrite, or choose another name", path.display())
            }
            Self::Exist(path, count) => write!(
                f,
                "{} exists, and {} more of the files to write; replace them with --overwrite, or choose another name",
                path.display(),
                count - 1
            ),
        }
    }
}

impl std::error::Error for TargetError {}

/// The folder that files go into. Where it was made for them and none came, it goes away with this.
#[derive(Debug)]
#[must_use = "the folder stays as long as this does"]
pub struct OutputFolder {
    made: Option<PathBuf>,
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        if let Some(folder) = &self.made {
            // Refused where the folder holds anything, as it does after a good bake.
            let _ = std::fs::remove_dir(folder);
        }
    }
}

/// Checks that the frames' files can be made, and makes the output folder (its last level only).
pub fn make_ready(pattern: &FramePattern, frames: &[i64], overwrite: bool) -> Result<OutputFolder, TargetError> {
    let folder = if pattern.folder().as_os_str().is_empty() { Path::new(".") } else { pattern.folder() };
    if !overwrite {
        let exist: Vec<_> = frames.iter().map(|&frame| pattern.file(frame)).filter(|file| file.exists()).collect();
        if let Some(first) = exist.first() {
            return Err(TargetError::Exist(first.clone(), exist.len()));
        }
    }
    let mut output = OutputFolder { made: None };
    match std::fs::metadata(folder) {
        Ok(metadata) if metadata.is_dir() => {}
        Ok(_) => return Err(TargetError::Folder(folder.into(), io::ErrorKind::NotADirectory.into())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => match std::fs::create_dir(folder) {
            Ok(()) => output.made = Some(folder.into()),
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Err(TargetError::NoParent(folder.into())),
            Err(error) => return Err(TargetError::Folder(folder.into(), error)),
        },
        Err(error) => return Err(TargetError::Folder(folder.into(), error)),
    }
    // A read-only folder is better known now than after the first frame.
    tempfile::Builder::new()
        .prefix(".hfvdb-")
        .suffix(".tmp")
        .tempfile_in(folder)
        .map_err(|error| TargetError::Folder(folder.into(), error))?;
    Ok(output)
}
