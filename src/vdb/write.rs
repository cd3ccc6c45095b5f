//! From a frame to a file that is whole.

use std::path::Path;

use super::bridge::ffi;
use super::{Error, Frame, encode, read_back};
use crate::disk::{self, Written};

/// How a file's buffers are compressed. In all cases inactive voxels are not stored where they can be restored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// Blosc: fast, and what Houdini writes.
    #[default]
    Blosc,
    /// Zip: slow. OpenVDB does not apply it to level sets and fog volumes.
    Zip,
    /// None.
    None,
}

impl Compression {
    pub(super) fn codec(self) -> ffi::Codec {
        match self {
            Self::Blosc => ffi::Codec::Blosc,
            Self::Zip => ffi::Codec::Zip,
            Self::None => ffi::Codec::None,
        }
    }
}

/// How to write a file.
#[derive(Clone, Copy, Debug, Default)]
pub struct WriteOptions {
    /// How buffers are compressed.
    pub compression: Compression,
    /// Whether a file of that name may be replaced.
    pub overwrite: bool,
}

/// Writes one frame to one file. Whatever fails, nothing is left behind and a file of that name is as it was.
///
/// # Errors
/// Those of [`encode`], [`disk::stage`] and [`disk::Staged::commit`].
pub fn write(path: impl AsRef<Path>, frame: &Frame<'_>, options: &WriteOptions) -> Result<Written, Error> {
    let path = path.as_ref();
    disk::check_target(path, options.overwrite)?;
    let pieces = encode(frame, options.compression).map_err(|error| match error {
        Error::Library { message } => Error::File { path: path.into(), message },
        error => error,
    })?;
    let (staged, sound) = rayon::join(|| disk::stage(path, &pieces, options.overwrite), || read_back(&pieces, path));
    let staged = staged?;
    sound?;
    Ok(staged.commit()?)
}
