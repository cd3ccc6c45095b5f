//! Files under temporary names, known to the process, so that an interrupted one leaves none behind.

use std::fs::Permissions;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use tempfile::NamedTempFile;

use super::Error;
use super::register::{Entry, LIVE, Register};

/// Not `.vdb`: a program that lists a folder's frames must not find it.
const SUFFIX: &str = ".hfvdb-tmp";

/// A file under a temporary name beside its final one; dropped, it is deleted.
pub struct Temporary {
    // Fields drop in this order: the file goes before its entry in the register.
    file: NamedTempFile,
    entry: Option<Entry>,
}

impl Temporary {
    /// A new empty file in the folder where `target` will stand.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn beside(target: &Path) -> Result<Self, Error> {
        Self::registered(&LIVE, target)
    }

    pub(super) fn registered(register: &'static Register, target: &Path) -> Result<Self, Error> {
        let name = target.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let make = || {
            tempfile::Builder::new()
                .prefix(&format!(".{name}."))
                .suffix(SUFFIX)
                .permissions(Permissions::from_mode(0o666)) // less the umask, as for any file the user makes
                .tempfile_in(folder_of(target))
                .map_err(|error| Error::system(target, "make a file in its folder", error))
        };
        let (file, entry) = register.enter(make, |file| Some(file.path().to_path_buf()))?;
        Ok(Self { file, entry })
    }

    /// The file itself.
    pub fn file_mut(&mut self) -> &mut std::fs::File {
        self.file.as_file_mut()
    }

    /// Gives the file its final name, and syncs the folder. `overwrite` allows to replace a file of that name.
    ///
    /// # Errors
    /// [`Error::Exists`] unless `overwrite`; [`Error::System`] when the system refuses.
    pub fn persist(self, target: &Path, overwrite: bool) -> Result<(), Error> {
        let Self { file, entry } = self;
        let path = file.into_temp_path();
        let renamed = if overwrite { path.persist(target) } else { path.persist_noclobber(target) };
        drop(entry);
        renamed.map_err(|failed| match failed.error.kind() {
            std::io::ErrorKind::AlreadyExists if !overwrite => Error::Exists { path: target.into() },
            _ => Error::system(target, "give the finished file its name", failed.error),
        })?;
        sync_folder(target)
    }
}

/// Writes a small file so that it is whole or as it was, and on the disk. A file that it replaces leaves its permissions.
///
/// # Errors
/// When the system refuses.
pub fn write_whole(target: &Path, bytes: &[u8]) -> Result<(), Error> {
    write(target, bytes, true)
}

/// The same where there is no file of that name.
///
/// # Errors
/// [`Error::Exists`] where there is one, and when the system refuses.
pub fn write_new(target: &Path, bytes: &[u8]) -> Result<(), Error> {
    write(target, bytes, false)
}

fn write(target: &Path, bytes: &[u8], overwrite: bool) -> Result<(), Error> {
    let mut temporary = Temporary::beside(target)?;
    let file = temporary.file_mut();
    if let Some(replaced) = std::fs::metadata(target).ok().filter(|_| overwrite) {
        let kept = file.set_permissions(replaced.permissions());
        kept.map_err(|error| Error::system(target, "keep its permissions", error))?;
    }
    file.write_all(bytes).and_then(|()| file.sync_all()).map_err(|error| Error::system(target, "write it", error))?;
    temporary.persist(target, overwrite)
}

/// The final name that a temporary's name was made from; `None` for other names.
pub fn temporary_target(name: &str) -> Option<&str> {
    let (target, random) = name.strip_prefix('.')?.strip_suffix(SUFFIX)?.rsplit_once('.')?;
    (!random.is_empty()).then_some(target)
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
pub fn folder_of(target: &Path) -> &Path {
    match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}
