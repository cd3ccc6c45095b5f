//! Which temporaries and locks exist now, so that an interrupted process leaves none behind.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A list of files that exist now and shall not outlive the process.
pub(super) struct Register(Mutex<BTreeSet<PathBuf>>);

/// Those of this process.
pub(super) static LIVE: Register = Register::new();

/// Deletes the temporary files and locks of this process; writes that are under way then fail, and others wait for ever.
/// For the thread that handles signals, just before the process ends.
pub fn remove_registered() {
    // Held until the end: nothing new is made in the process's last moments.
    std::mem::forget(LIVE.remove_all());
}

impl Register {
    pub const fn new() -> Self {
        Self(Mutex::new(BTreeSet::new()))
    }

    /// Deletes all, and gives the list: while it is held, no file is entered.
    pub fn remove_all(&self) -> MutexGuard<'_, BTreeSet<PathBuf>> {
        let mut live = self.lock();
        for path in std::mem::take(&mut *live) {
            // Whatever cannot be deleted is left; there is nobody to tell.
            let _ = std::fs::remove_file(path);
        }
        live
    }

    /// Makes a file and enters it, as one step for [`Self::remove_all`]: no signal finds the file made and not entered.
    pub fn enter<T, E>(
        &'static self,
        make: impl FnOnce() -> Result<T, E>,
        path_of: impl FnOnce(&T) -> Option<PathBuf>,
    ) -> Result<(T, Option<Entry>), E> {
        let mut live = self.lock();
        let made = make()?;
        let entry = path_of(&made).map(|path| {
            live.insert(path.clone());
            Entry { register: self, path }
        });
        Ok((made, entry))
    }

    /// The set stays usable when a thread panicked that held it: it is changed by single insertions and removals.
    fn lock(&self) -> MutexGuard<'_, BTreeSet<PathBuf>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// An entry in a register; dropped, it is struck out.
pub(super) struct Entry {
    register: &'static Register,
    path: PathBuf,
}

impl Entry {
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Entry {
    fn drop(&mut self) {
        self.register.lock().remove(&self.path);
    }
}
