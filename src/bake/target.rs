//! Where the files go: checked before any work is done.

use std::fmt;
use std::io;
use std::path::PathBuf;

use super::sequence::Sequence;
use crate::disk::{self, Temporary, folder_of};
use crate::terminal;

/// Why files cannot go where they should.
#[derive(Debug)]
pub enum TargetError {
    /// The parent of the output folder is not there.
    NoParent(PathBuf),
    /// Something else stands where the output folder should be, or it cannot be made.
    Folder(PathBuf, io::Error),
    /// The name is too long for what stands beside the frames.
    LongName(PathBuf),
}

impl fmt::Display for TargetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoParent(path) => write!(
                f,
                "{}: the folder {} does not exist; only the last folder of a path is made, make the others first",
                terminal::path(path),
                terminal::path(path.parent().unwrap_or(path))
            ),
            Self::Folder(path, error) => {
                write!(f, "{}: cannot write into this folder: {error}; choose another with -o", terminal::path(path))
            }
            Self::LongName(path) => write!(
                f,
                "{}: this name is too long for the records beside the frames; choose a shorter one",
                terminal::path(path)
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

/// Checks that frames can be written, without writing anything.
pub fn check_place(sequence: &Sequence) -> Result<(), TargetError> {
    let folder = sequence.folder();
    if sequence.name_is_too_long() {
        return Err(TargetError::LongName(sequence.pattern.folder().join(sequence.pattern.text())));
    }
    match std::fs::metadata(folder) {
        Ok(metadata) if metadata.is_dir() => Ok(()),
        Ok(_) => Err(TargetError::Folder(folder.into(), io::ErrorKind::NotADirectory.into())),
        Err(error) if error.kind() == io::ErrorKind::NotFound && folder_of(folder).is_dir() => Ok(()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Err(TargetError::NoParent(folder.into())),
        Err(error) => Err(TargetError::Folder(folder.into(), error)),
    }
}

/// Makes the output folder (its last level only), and makes sure that it takes files.
pub fn make_ready(sequence: &Sequence) -> Result<OutputFolder, TargetError> {
    check_place(sequence)?;
    let folder = sequence.folder();
    let mut output = OutputFolder { made: None };
    match std::fs::create_dir(folder) {
        Ok(()) => output.made = Some(folder.into()),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
        // A folder that is there may say so only after it said that nothing can be made beside it.
        Err(_) if folder.is_dir() => {}
        Err(error) => return Err(TargetError::Folder(folder.into(), error)),
    }
    // A read-only folder is better known now than after the first frame.
    Temporary::beside(&sequence.manifest()).map_err(|error| match error {
        disk::Error::System { source, .. } => TargetError::Folder(folder.into(), source),
        error => TargetError::Folder(folder.into(), io::Error::other(error)),
    })?;
    Ok(output)
}
