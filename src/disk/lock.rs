//! Locks of the operating system on files made for them: they end with the process that holds them, however it ends.

use std::fs::{File, OpenOptions, TryLockError};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use super::Error;
use super::register::{Entry, LIVE};

/// A lock that is held. Dropped, it is let go and its file deleted.
pub struct FileLock {
    // Fields drop in this order: the file is deleted (see `Drop`), let go, then struck out of the register.
    _file: File,
    entry: Entry,
    enforced: bool,
}

impl FileLock {
    /// Takes a lock; `None` where another process, or another holder in this one, has it.
    ///
    /// # Errors
    /// When the file cannot be made. A file system without locks gives one that is not [`Self::enforced`].
    pub fn try_take(path: &Path) -> Result<Option<Self>, Error> {
        loop {
            let attempt = || -> Result<Attempt, Error> {
                let mut options = OpenOptions::new();
                let file = options.read(true).write(true).create(true).truncate(false).open(path);
                let file = file.map_err(|error| Error::system(path, "make this lock", error))?;
                let enforced = match file.try_lock() {
                    Ok(()) => true,
                    Err(TryLockError::WouldBlock) => return Ok(Attempt::Held),
                    Err(TryLockError::Error(error)) if no_locks(&error) => false,
                    Err(TryLockError::Error(error)) => return Err(Error::system(path, "take this lock", error)),
                };
                // Who held it before may have deleted it between our opening and our locking: then it is nobody's.
                Ok(if is_at(&file, path) { Attempt::Taken(file, enforced) } else { Attempt::Gone })
            };
            let path_of = |attempt: &Attempt| matches!(attempt, Attempt::Taken(..)).then(|| path.to_path_buf());
            match LIVE.enter(attempt, path_of)? {
                (Attempt::Taken(file, enforced), Some(entry)) => {
                    return Ok(Some(Self { _file: file, entry, enforced }));
                }
                (Attempt::Held, _) => return Ok(None),
                _ => {}
            }
        }
    }

    /// Whether the file system keeps others out.
    pub fn enforced(&self) -> bool {
        self.enforced
    }
}

impl Drop for FileLock {
    fn drop(&mut self) {
        // While it is held, so that nobody finds it free and then gone. What cannot be deleted holds nobody up.
        let _ = std::fs::remove_file(self.entry.path());
    }
}

enum Attempt {
    Taken(File, bool),
    Held,
    Gone,
}

/// Whether the system says that there are no locks here.
fn no_locks(error: &io::Error) -> bool {
    use rustix::io::Errno;
    let none = [Errno::OPNOTSUPP, Errno::NOSYS, Errno::NOLCK];
    error.raw_os_error().is_some_and(|code| none.iter().any(|errno| errno.raw_os_error() == code))
}

fn is_at(file: &File, path: &Path) -> bool {
    match (file.metadata(), std::fs::metadata(path)) {
        (Ok(own), Ok(there)) => (own.dev(), own.ino()) == (there.dev(), there.ino()),
        _ => false,
    }
}
