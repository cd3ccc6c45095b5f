//! Large files in pieces: staged under a temporary name, compared with what the disk holds, then committed.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::{Error, Temporary, folder_of};

/// Bytes that are written or read at once where a file is never whole in memory.
const BUFFER: usize = 1 << 20;

/// A file that was written.
#[derive(Clone, Copy, Debug)]
pub struct Written {
    /// Its size.
    pub bytes: u64,
    /// SHA-256 of its bytes, which were read back from the disk and compared.
    pub sha256: [u8; 32],
}

/// A file that stands whole under a temporary name, not yet for certain on the disk. Where it is dropped, it goes.
pub struct Staged {
    temporary: Temporary,
    path: PathBuf,
    overwrite: bool,
    written: Written,
}

impl Staged {
    /// What was written.
    pub fn written(&self) -> Written {
        self.written
    }

    /// Syncs the file to the disk and gives it its name.
    ///
    /// # Errors
    /// [`Error::Exists`] when there is a file of that name by now unless overwriting is allowed, and when the system
    /// refuses.
    pub fn commit(self) -> Result<Written, Error> {
        let Self { mut temporary, path, overwrite, written } = self;
        temporary.file_mut().sync_all().map_err(|error| Error::system(&path, "sync it to the disk", error))?;
        temporary.persist(&path, overwrite)?;
        Ok(written)
    }
}

/// Writes a file's pieces under a temporary name in the folder of `path`, reads them back and compares them. Whatever
/// fails, nothing is left behind.
///
/// # Errors
/// When the system refuses, such as on a full disk; [`Error::Damaged`] when the disk does not hold what was written.
pub fn stage(path: &Path, pieces: &[Vec<u8>], overwrite: bool) -> Result<Staged, Error> {
    let mut temporary = Temporary::beside(path)?;
    let (sent, sha256) = rayon::join(|| send(pieces, &mut temporary, path), || sha256(pieces));
    let written = Written { bytes: sent?, sha256 };
    Ok(Staged { temporary, path: path.into(), overwrite, written })
}

/// Writes piece after piece, and compares each with what is then read back, while it is still in the caches. Returns the
/// bytes of all. Messages name `path`, the final name.
fn send(pieces: &[Vec<u8>], temporary: &mut Temporary, path: &Path) -> Result<u64, Error> {
    let file = temporary.file_mut();
    let reading = |error| Error::system(path, "read it back", error);
    let (mut arrived, mut start) = (Vec::new(), 0);
    for piece in pieces {
        file.write_all_at(piece, start).map_err(|error| Error::system(path, "write it", error))?;
        arrived.resize(piece.len().max(arrived.len()), 0);
        let arrived = &mut arrived[..piece.len()];
        file.read_exact_at(arrived, start).map_err(reading)?;
        if arrived != piece {
            let same = arrived.iter().zip(piece).take_while(|(a, b)| a == b).count();
            let problem = "the disk does not hold what was written".into();
            return Err(Error::Damaged { path: path.into(), offset: start + same as u64, problem });
        }
        start += piece.len() as u64;
    }
    let bytes = file.metadata().map_err(reading)?.len();
    if bytes != start {
        let problem = format!("the disk holds {bytes} bytes, not the {start} that were written");
        return Err(Error::Damaged { path: path.into(), offset: start, problem });
    }
    Ok(bytes)
}

/// As [`stage`], of what `write` sends bit by bit, so that no more than that is in memory.
///
/// # Errors
/// As [`stage`], and those of `write`.
pub fn stage_stream<E: From<Error>>(
    path: &Path,
    overwrite: bool,
    write: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<Staged, E> {
    let mut temporary = Temporary::beside(path)?;
    let mut out =
        BufWriter::with_capacity(BUFFER, Hashing { file: temporary.file_mut(), hash: Sha256::new(), bytes: 0 });
    write(&mut out)?;
    let writing = |error| Error::system(path, "write it", error);
    out.flush().map_err(writing)?;
    let Hashing { hash, bytes, .. } = out.into_inner().map_err(|error| writing(error.into_error()))?;
    let sha256 = hash.finalize().into();
    let (arrived, there) = hash_of(temporary.file_mut()).map_err(|error| Error::system(path, "read it back", error))?;
    if (arrived, there) != (bytes, sha256) {
        let problem = "the disk does not hold what was written".into();
        return Err(Error::Damaged { path: path.into(), offset: 0, problem }.into());
    }
    Ok(Staged { temporary, path: path.into(), overwrite, written: Written { bytes, sha256 } })
}

/// A file with the SHA-256 of what went into it.
struct Hashing<'a> {
    file: &'a mut File,
    hash: Sha256,
    bytes: u64,
}

impl Write for Hashing<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = self.file.write(bytes)?;
        self.hash.update(&bytes[..taken]);
        self.bytes += taken as u64;
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// How long a file is, and its SHA-256.
fn hash_of(file: &File) -> io::Result<(u64, [u8; 32])> {
    let (mut hash, mut buffer, mut start) = (Sha256::new(), vec![0; BUFFER], 0);
    loop {
        match file.read_at(&mut buffer, start)? {
            0 => return Ok((start, hash.finalize().into())),
            count => {
                hash.update(&buffer[..count]);
                start += count as u64;
            }
        }
    }
}

fn sha256(pieces: &[Vec<u8>]) -> [u8; 32] {
    let mut hash = Sha256::new();
    pieces.iter().for_each(|piece| hash.update(piece));
    hash.finalize().into()
}

/// What is wrong with a target before any work is done.
///
/// # Errors
/// [`Error::Exists`] unless `overwrite`; [`Error::System`] where no file can stand.
pub fn check_target(path: &Path, overwrite: bool) -> Result<(), Error> {
    if path.file_name().is_none() || path.is_dir() {
        return Err(Error::system(path, "write it", io::ErrorKind::IsADirectory.into()));
    }
    let folder = folder_of(path);
    match std::fs::metadata(folder) {
        Err(error) => return Err(Error::system(folder, "write into it", error)),
        Ok(metadata) if !metadata.is_dir() => {
            return Err(Error::system(folder, "write into it", io::ErrorKind::NotADirectory.into()));
        }
        Ok(_) => {}
    }
    if !overwrite && path.symlink_metadata().is_ok() {
        return Err(Error::Exists { path: path.into() });
    }
    Ok(())
}
