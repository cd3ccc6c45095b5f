//! From a frame to a file that is whole.

use std::fs::File;
use std::ops::Range;
use std::os::fd::AsRawFd;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::bridge::ffi;
use super::walk::walk_pieces;
use super::{Encoded, Error, Frame, encode};
use crate::disk::{self, Temporary, folder_of};

/// So many bytes of a file are sent to the disk at a time while the rest is written, so that little is left to wait for
/// when the file is synced.
const WRITTEN_OUT: u64 = 4 << 20;

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

/// A file that was written.
#[derive(Clone, Copy, Debug)]
pub struct Written {
    /// Its size.
    pub bytes: u64,
    /// SHA-256 of its bytes, which were read back from the disk and compared.
    pub sha256: [u8; 32],
}

/// Writes one frame to one file.
///
/// # Errors
/// Those of [`encode`] and [`Encoded::write`].
pub fn write(path: impl AsRef<Path>, frame: &Frame<'_>, options: &WriteOptions) -> Result<Written, Error> {
    arrive(path, frame, options)?.settle()
}

/// The first half of [`write()`]: all but syncing and renaming.
///
/// # Errors
/// Those of [`encode`] and [`Encoded::arrive`].
pub fn arrive(path: impl AsRef<Path>, frame: &Frame<'_>, options: &WriteOptions) -> Result<Arrived, Error> {
    let path = path.as_ref();
    check_target(path, options.overwrite)?;
    let encoded = encode(frame, options.compression).map_err(|error| match error {
        Error::Library { message } => Error::File { path: path.into(), message },
        error => error,
    })?;
    encoded.arrive(path, options.overwrite)
}

/// A file that has arrived whole under a temporary name, not yet for certain on the disk. Where it is dropped, it goes.
pub struct Arrived {
    temporary: Temporary,
    path: PathBuf,
    overwrite: bool,
    written: Written,
}

impl Arrived {
    /// What was written.
    pub fn written(&self) -> Written {
        self.written
    }

    /// Syncs the file to the disk and gives it its name.
    ///
    /// # Errors
    /// [`Error::Disk`] when there is a file of that name by now unless overwriting is allowed, and when the system
    /// refuses.
    pub fn settle(self) -> Result<Written, Error> {
        let Self { mut temporary, path, overwrite, written } = self;
        temporary.file_mut().sync_all().map_err(|error| Error::system(&path, "sync it to the disk", error))?;
        temporary.persist(&path, overwrite)?;
        Ok(written)
    }
}

impl Encoded {
    /// Writes the file under a temporary name in the target's folder, reads it back and checks it, syncs it and renames
    /// it. Whatever fails, nothing is left behind and a file of that name is as it was.
    ///
    /// # Errors
    /// Those of [`Encoded::arrive`] and [`Arrived::settle`].
    pub fn write(self, path: impl AsRef<Path>, overwrite: bool) -> Result<Written, Error> {
        self.arrive(path, overwrite)?.settle()
    }

    /// The first half of [`Encoded::write`]: all but syncing and renaming.
    ///
    /// # Errors
    /// [`Error::Disk`] when there is a file of that name unless overwriting is allowed, and when the system refuses, such
    /// as on a full disk; [`Error::Damaged`] when the disk does not hold what was written.
    pub fn arrive(self, path: impl AsRef<Path>, overwrite: bool) -> Result<Arrived, Error> {
        let path = path.as_ref();
        check_target(path, overwrite)?;
        let mut temporary = Temporary::beside(path)?;
        // What is hashed and walked is what was meant to be written; that it arrived is checked byte by byte.
        let check = || walk_pieces(&self.pieces, path).map(|_| self.sha256());
        let (sent, checked) = rayon::join(|| self.send(&mut temporary, path), check);
        sent?;
        let written = Written { bytes: self.bytes(), sha256: checked? };
        Ok(Arrived { temporary, path: path.into(), overwrite, written })
    }

    /// Writes piece after piece, and compares each with what is then read back, while it is still in the caches.
    /// Messages name `path`, the final name.
    fn send(&self, temporary: &mut Temporary, path: &Path) -> Result<(), Error> {
        let file = temporary.file_mut();
        let reading = |error| Error::system(path, "read it back", error);
        let (mut arrived, mut start, mut on_its_way) = (Vec::new(), 0, 0);
        for piece in &self.pieces {
            file.write_all_at(piece, start).map_err(|error| Error::system(path, "write it", error))?;
            arrived.resize(piece.len().max(arrived.len()), 0);
            let arrived = &mut arrived[..piece.len()];
            file.read_exact_at(arrived, start).map_err(reading)?;
            if arrived != piece {
                let same = arrived.iter().zip(piece).take_while(|(a, b)| a == b).count();
                let problem = format!("the disk does not hold what was written, {} bytes", self.bytes());
                return Err(Error::Damaged { path: path.into(), offset: start + same as u64, problem });
            }
            start += piece.len() as u64;
            if start - on_its_way >= WRITTEN_OUT {
                begin_to_write_out(file, on_its_way..start);
                on_its_way = start;
            }
        }
        let bytes = file.metadata().map_err(reading)?.len();
        if bytes != start {
            let problem = format!("the disk holds {bytes} bytes, not the {start} that were written");
            return Err(Error::Damaged { path: path.into(), offset: start, problem });
        }
        Ok(())
    }

    fn sha256(&self) -> [u8; 32] {
        let mut hash = Sha256::new();
        self.pieces.iter().for_each(|piece| hash.update(piece));
        hash.finalize().into()
    }
}

/// Has the system begin to bring a part of a file to the disk, and waits for nothing. Whether it gets there is told when
/// the file is synced; where the system or the file's place knows no such thing, all is left to that.
#[expect(unsafe_code, reason = "no library has this call in a safe form")]
fn begin_to_write_out(file: &File, part: Range<u64>) {
    let [start, bytes] = [part.start, part.end - part.start].map(|number| number as i64);
    // SAFETY: the call gets numbers alone, of which the descriptor is open as long as `file` lives.
    unsafe { libc::sync_file_range(file.as_raw_fd(), start, bytes, libc::SYNC_FILE_RANGE_WRITE) };
}

/// What is wrong with a target before any work is done.
fn check_target(path: &Path, overwrite: bool) -> Result<(), Error> {
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
    if !overwrite && path.symlink_metadata().is_ok() {
        return Err(disk::Error::Exists { path: path.into() }.into());
    }
    Ok(())
}
