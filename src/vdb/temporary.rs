//! Files under temporary names, known to the process, so that an interrupted one leaves none behind.

use std::collections::BTreeSet;
use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

use super::Error;

/// A list of temporary files that exist now.
pub(super) struct Register(Mutex<BTreeSet<PathBuf>>);

/// Those of this process.
static LIVE: Register = Register::new();

/// Not `.vdb`: a program that lists a folder's frames must not find it.
const SUFFIX: &str = ".hfvdb-tmp";

/// Deletes the temporary files of every write that is under way in this process; these writes then fail. For the
/// thread that handles signals, just before the process ends.
pub fn remove_temporaries() {
    LIVE.remove_all();
}

impl Register {
    pub const fn new() -> Self {
        Self(Mutex::new(BTreeSet::new()))
    }

    pub fn remove_all(&self) {
        for path in std::mem::take(&mut *self.lock()) {
            // Whatever cannot be deleted is left; there is nobody to tell.
            let _ = std::fs::remove_file(path);
        }
    }

    /// The set stays usable when a thread panicked that held it: it is changed by single insertions and removals.
    fn lock(&self) -> MutexGuard<'_, BTreeSet<PathBuf>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A file under a temporary name beside its final one; dropped, it is deleted.
pub(super) struct Temporary {
    // Fields drop in this order: the file goes before its entry in the register.
    file: NamedTempFile,
    registration: Registration,
}

/// An entry in a register.
struct Registration {
    register: &'static Register,
    path: PathBuf,
}

impl Drop for Registration {
    fn drop(&mut self) {
        self.register.lock().remove(&self.path);
    }
}

impl Temporary {
    /// A new empty file in the folder where `target` will stand.
    pub fn beside(target: &Path) -> Result<Self, Error> {
        Self::registered(&LIVE, target)
    }

    pub fn registered(register: &'static Register, target: &Path) -> Result<Self, Error> {
        let name: String =
            target.file_name().map(|name| name.to_string_lossy().chars().take(40).collect()).unwrap_or_default();
        // The lock is held meanwhile, so that no signal finds the file made and not yet registered.
        let mut live = register.lock();
        let file = tempfile::Builder::new()
            .prefix(&format!(".{name}."))
            .suffix(SUFFIX)
            .permissions(Permissions::from_mode(0o666)) // less the umask, as for any file the user makes
            .tempfile_in(folder_of(target))
            .map_err(|error| Error::system(target, "make a file in its folder", error))?;
        live.insert(file.path().to_path_buf());
        drop(live);
        let registration = Registration { register, path: file.path().to_path_buf() };
        Ok(Self { file, registration })
    }

    /// The file itself.
    pub fn file_mut(&mut self) -> &mut std::fs::File {
        self.file.as_file_mut()
    }

    /// Gives the file its final name, and syncs the folder. `overwrite` allows to replace a file of that name.
    pub fn persist(self, target: &Path, overwrite: bool) -> Result<(), Error> {
        let Self { file, registration } = self;
        let path = file.into_temp_path();
        let renamed = if overwrite { path.persist(target) } else { path.persist_noclobber(target) };
        drop(registration);
        renamed.map_err(|failed| match failed.error.kind() {
            std::io::ErrorKind::AlreadyExists if !overwrite => Error::Exists { path: target.into() },
            _ => Error::system(target, "give the finished file its name", failed.error),
        })?;
        sync_folder(target)
    }
}

/// The rename itself survives a power cut only once the folder is on the disk.
fn sync_folder(target: &Path) -> Result<(), Error> {
    std::fs::File::open(folder_of(target))
        .and_then(|folder| folder.sync_all())
        .or_else(|error| match error.kind() {
            // Some network file systems do not sync folders, or let them be written but not opened.
            std::io::ErrorKind::InvalidInput
            | std::io::ErrorKind::Unsupported
            | std::io::ErrorKind::PermissionDenied => Ok(()),
            _ => Err(error),
        })
        .map_err(|error| Error::system(target, "sync its folder to the disk", error))
}

/// The folder that a path's last part stands in.
pub(super) fn folder_of(target: &Path) -> &Path {
    match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}
