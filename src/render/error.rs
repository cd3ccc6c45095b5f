//! Why a picture could not be stored, and how one is: whole under its name, or not at all.

use crate::terminal;
use std::{
    fmt,
    io::Write,
    path::{Path, PathBuf},
};

/// Why a picture could not be stored.
#[derive(Debug)]
pub enum PictureError {
    /// The picture has no pixels, or more than its format can hold.
    Size {
        /// Pixels across.
        width: usize,
        /// Pixels down.
        height: usize,
    },
    /// The encoder of PNG refused.
    Png(png::EncodingError),
    /// The encoder of EXR refused.
    Exr(exr::error::Error),
    /// The file could not be written.
    Write {
        /// Where it should have gone.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

impl fmt::Display for PictureError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size { width, height } => {
                write!(
                    out,
                    "a picture of {width} by {height} pixels cannot be stored: take between 1 and 65535 each way"
                )
            }
            Self::Png(source) => write!(out, "the picture could not be encoded as PNG: {source}"),
            Self::Exr(source) => write!(out, "the picture could not be encoded as EXR: {source}"),
            Self::Write { path, source } => {
                write!(
                    out,
                    "cannot write the picture {}: {source}; is its folder there and writable?",
                    terminal::path(path)
                )
            }
        }
    }
}

impl std::error::Error for PictureError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Size { .. } => None,
            Self::Png(source) => Some(source),
            Self::Exr(source) => Some(source),
            Self::Write { source, .. } => Some(source),
        }
    }
}

impl From<png::EncodingError> for PictureError {
    fn from(source: png::EncodingError) -> Self {
        Self::Png(source)
    }
}

/// Stores the bytes of a picture: whole under its name, or not at all. A file of that name is replaced.
///
/// # Errors
/// [`PictureError::Write`].
pub fn save(path: &Path, bytes: &[u8]) -> Result<(), PictureError> {
    let failed = |source| PictureError::Write { path: path.to_owned(), source };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // A temporary file is private to its owner; a picture gets what any new file would.
    let mut options = tempfile::Builder::new();
    #[cfg(unix)]
    options.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = options.prefix(".hfvdb-").suffix(".part").tempfile_in(folder).map_err(failed)?;
    file.write_all(bytes).map_err(failed)?;
    file.persist(path).map_err(|error| failed(error.error))?;
    Ok(())
}

/// A size as PNG takes it.
pub(super) fn png_size(width: usize, height: usize) -> Result<(u32, u32), PictureError> {
    let fits = |edge: usize| u16::try_from(edge).ok().filter(|&edge| edge > 0).map(u32::from);
    fits(width).zip(fits(height)).ok_or(PictureError::Size { width, height })
}
