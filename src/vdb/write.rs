//! From a frame to a file that is whole.

use std::io::{Read, Seek, Write};
use std::path::Path;

use sha2::{Digest, Sha256};

use super::bridge::ffi;
use super::walk::walk_bytes;
use super::{Error, Frame};
use crate::disk::{self, Temporary, folder_of};

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
    fn codec(self) -> ffi::Codec {
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

/// A file that was written.
#[derive(Clone, Copy, Debug)]
pub struct Written {
    /// Its size.
    pub bytes: u64,
    /// SHA-256 of its bytes, as they were read back from the disk.
    pub sha256: [u8; 32],
}

/// A frame in OpenVDB's trees, independent of the blocks it came from.
pub struct Prepared {
    pub(super) frame: cxx::UniquePtr<ffi::Frame>,
}

/// Copies a frame's blocks into OpenVDB's trees, on all threads.
///
/// # Errors
/// [`Error::Grid`] for blocks, tiles or values that make no grid, also a value that is not finite.
pub fn prepare(frame: &Frame<'_>) -> Result<Prepared, Error> {
    Ok(Prepared { frame: frame.prepare()? })
}

/// Writes one frame to one file.
///
/// # Errors
/// Those of [`prepare`] and [`Prepared::write`].
pub fn write(path: impl AsRef<Path>, frame: &Frame<'_>, options: &WriteOptions) -> Result<Written, Error> {
    check_target(path.as_ref(), options)?;
    prepare(frame)?.write(path, options)
}

impl Prepared {
    /// How large the frame's file would be in bytes, by encoding it.
    ///
    /// # Errors
    /// When OpenVDB fails.
    pub fn encoded_bytes(&self, compression: Compression) -> Result<u64, Error> {
        let encoded = self.encoded(compression).map_err(|error| Error::Library { message: error.what().into() })?;
        Ok((0..encoded.pieces()).map(|index| encoded.piece(index).len() as u64).sum())
    }

    fn encoded(&self, compression: Compression) -> Result<cxx::UniquePtr<ffi::Encoded>, cxx::Exception> {
        ffi::encode(&self.frame, compression.codec())
    }

    /// Writes the frame: encoded on all threads, under a temporary name in the target's folder, read back and checked,
    /// synced and renamed. Whatever fails, nothing is left behind and a file of that name is as it was.
    ///
    /// # Errors
    /// [`Error::Disk`] when there is a file of that name unless overwriting is allowed, and when the system refuses, such
    /// as on a full disk; [`Error::Damaged`] when the disk does not hold what was written.
    pub fn write(&self, path: impl AsRef<Path>, options: &WriteOptions) -> Result<Written, Error> {
        let path = path.as_ref();
        check_target(path, options)?;
        let encoded = self
            .encoded(options.compression)
            .map_err(|error| Error::File { path: path.into(), message: error.what().into() })?;
        let mut temporary = Temporary::beside(path)?;
        let mut bytes = 0;
        for index in 0..encoded.pieces() {
            let piece = encoded.piece(index);
            temporary.file_mut().write_all(piece).map_err(|error| Error::system(path, "write it", error))?;
            bytes += piece.len() as u64;
        }
        drop(encoded);
        let sha256 = check_arrival(&mut temporary, bytes, path)?;
        temporary.file_mut().sync_all().map_err(|error| Error::system(path, "sync it to the disk", error))?;
        temporary.persist(path, options.overwrite)?;
        Ok(Written { bytes, sha256 })
    }
}

/// Reads back what was written, walks it and gives its SHA-256. Messages name `path`, the final name.
fn check_arrival(temporary: &mut Temporary, bytes: u64, path: &Path) -> Result<[u8; 32], Error> {
    let mut arrived = Vec::new();
    let file = temporary.file_mut();
    file.rewind()
        .and_then(|()| file.read_to_end(&mut arrived))
        .map_err(|error| Error::system(path, "read it back", error))?;
    if arrived.len() as u64 != bytes {
        let problem = format!("{bytes} bytes were written, and {} arrived", arrived.len());
        return Err(Error::Damaged { path: path.into(), offset: arrived.len() as u64, problem });
    }
    let (walked, sha256) = rayon::join(|| walk_bytes(&arrived, path), || Sha256::digest(&arrived));
    walked.map(|_| sha256.into())
}

/// What is wrong with a target before any work is done.
fn check_target(path: &Path, options: &WriteOptions) -> Result<(), Error> {
    if path.file_name().is_none() || path.is_dir() {
        return Err(Error::system(path, "write it", std::io::ErrorKind::IsADirectory.into()));
    }
    let folder = folder_of(path);
    match std::fs::metadata(folder) {
        Err(error) => return Err(Error::system(folder, "write into it", error)),
        Ok(metadata) if !metadata.is_dir() => {
            return Err(Error::system(folder, "write into it", std::io::ErrorKind::NotADirectory.into()));
        }
        Ok(_) => {}
    }
    if !options.overwrite && path.symlink_metadata().is_ok() {
        return Err(disk::Error::Exists { path: path.into() }.into());
    }
    Ok(())
}
