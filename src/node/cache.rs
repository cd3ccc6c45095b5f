//! Measured objects and plans of morphs kept in a folder, so that what processes and machines work out alike is worked out
//! once.
//!
//! An entry's name is a hash of all that decides the object (`Model::part_hash` and numbers) and of the program. Its bytes end
//! with their SHA-256: what is damaged, foreign or of another program counts as not there. Whatever goes wrong with the
//! folder, the object is measured, and one word of it kept for the caller.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use sha2::{Digest, Sha256};

use crate::disk::{self, FileLock};
use crate::distance::method::Measured;
use crate::distance::octree::{BuildError, DistanceObject};
use crate::morph::Plan;

/// What entries end with: measured objects, and plans.
const EXTENSIONS: [&str; 2] = ["distance", "plan"];
/// Objects of fewer samples are measured as fast as they are read: some ten microseconds each.
const WORTH: usize = 5000;
/// How long to wait for another process that measures the same, before measuring it too.
const PATIENCE: Duration = Duration::from_secs(600);
/// How long to wait before looking for its result again.
const PAUSE: Duration = Duration::from_millis(50);

/// A folder of measured objects and plans.
#[derive(Debug)]
pub struct Cache {
    folder: PathBuf,
    limit: u64,
    program: Vec<u8>,
    problem: Mutex<Option<String>>,
}

impl Cache {
    /// The key of what this program measures of a part of a scene, by these numbers.
    pub(crate) fn key(&self, part: &[u8], numbers: &[f64]) -> [u8; 32] {
        let mut digest = Sha256::new();
        for bytes in [&self.program[..], part] {
            digest.update((bytes.len() as u64).to_le_bytes());
            digest.update(bytes);
        }
        numbers.iter().for_each(|number| digest.update(number.to_bits().to_le_bytes()));
        digest.finalize().into()
    }

    /// A cache in a folder, which is made when it is needed, of at most so many bytes: entries that were not used for
    /// longest go first. `program` identifies the code that measures; entries of another are not used.
    pub fn new(folder: PathBuf, limit: u64, program: &[u8]) -> Self {
        Self { folder, limit, program: program.to_vec(), problem: Mutex::new(None) }
    }

    /// What went wrong with the folder, once.
    pub fn problem(&self) -> Option<String> {
        self.problem.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    fn note(&self, problem: impl Into<String>) {
        self.problem.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(problem.into());
    }

    /// The object of a key where it is known; else the task to measure it, once nobody else does. Who claims several
    /// claims them in the order of their keys, and measures none before it has all: else two would wait for each other.
    /// `waiting` is called once where it has to wait.
    pub(crate) fn claim(
        &self,
        key: [u8; 32],
        cancel: &AtomicBool,
        waiting: &dyn Fn(),
    ) -> Result<Claim<'_>, BuildError> {
        let path = self.path(key, EXTENSIONS[0]);
        let open = |path, lock| Claim::Open(Task { cache: self, path, _lock: lock });
        if let Some(known) = self.read(&path) {
            return Ok(Claim::Known(known));
        }
        if !self.make_folder() {
            return Ok(open(path, None));
        }
        let start = Instant::now();
        let mut waits = false;
        loop {
            match FileLock::try_take(&path.with_extension("lock")) {
                Ok(Some(lock)) => {
                    // Whoever held it before may have just finished.
                    return Ok(self.read(&path).map_or_else(|| open(path, Some(lock)), Claim::Known));
                }
                Ok(None) => {}
                Err(error) => {
                    self.note(format!("nothing is kept in the cache: {error}"));
                    return Ok(open(path, None));
                }
            }
            if start.elapsed() > PATIENCE {
                return Ok(open(path, None));
            }
            if cancel.load(Ordering::Relaxed) {
                return Err(BuildError::Cancelled);
            }
            if !std::mem::replace(&mut waits, true) {
                waiting();
            }
            std::thread::sleep(PAUSE);
        }
    }

    /// The plan of a key, where it is known. Planning takes a second or two: nobody waits for another who does it.
    pub(crate) fn plan(&self, key: [u8; 32]) -> Option<Plan> {
        self.entry(&self.path(key, EXTENSIONS[1]), |bytes| serde_json::from_slice(bytes).ok())
    }

    /// Keeps a plan.
    pub(crate) fn keep_plan(&self, key: [u8; 32], plan: &Plan) {
        if let (Ok(bytes), true) = (serde_json::to_vec(plan), self.make_folder()) {
            self.write(&self.path(key, EXTENSIONS[1]), bytes);
        }
    }

    fn path(&self, key: [u8; 32], extension: &str) -> PathBuf {
        let name: String = key.iter().map(|byte| format!("{byte:02x}")).collect();
        self.folder.join(&name).with_extension(extension)
    }

    /// Whether the folder is there by now.
    fn make_folder(&self) -> bool {
        let made = std::fs::create_dir_all(&self.folder);
        if let Err(error) = &made {
            self.note(format!("the cache {} cannot be made, so nothing is kept: {error}", self.folder.display()));
        }
        made.is_ok()
    }

    /// An object, if its entry is whole.
    fn read(&self, path: &Path) -> Option<Arc<DistanceObject>> {
        self.entry(path, DistanceObject::from_bytes).map(Arc::new)
    }

    /// An entry, if it is whole.
    fn entry<T>(&self, path: &Path, from_bytes: impl FnOnce(&[u8]) -> Option<T>) -> Option<T> {
        if !path.exists() {
            return None;
        }
        let bytes = match disk::read(path) {
            Ok(bytes) => bytes,
            // Another process made room.
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return None,
            Err(error) => {
                self.note(format!("{} cannot be read, and its object is measured again: {error}", path.display()));
                return None;
            }
        };
        let Some(whole) = sound(&bytes).and_then(from_bytes) else {
            self.note(format!("{} is damaged, and its object is measured again", path.display()));
            return None;
        };
        // The least recently used go first. What cannot be touched is still of use.
        let now = std::fs::File::options().append(true).open(path);
        let _ = now.and_then(|file| file.set_modified(SystemTime::now()));
        Some(whole)
    }

    /// Writes an entry, with the sum of its bytes after them.
    fn write(&self, path: &Path, mut bytes: Vec<u8>) {
        let sum = Sha256::digest(&bytes);
        bytes.extend_from_slice(&sum);
        if bytes.len() as u64 > self.limit {
            return;
        }
        self.make_room(bytes.len() as u64);
        if let Err(error) = disk::write_whole(path, &bytes) {
            self.note(format!("an object is not kept in the cache: {error}"));
        }
    }

    /// Deletes entries until so many bytes fit. Others may do so at the same time: what is gone is gone.
    fn make_room(&self, bytes: u64) {
        let Ok(folder) = std::fs::read_dir(&self.folder) else { return };
        let mut entries: Vec<(SystemTime, u64, PathBuf)> = folder
            .flatten()
            .filter(|entry| entry.path().extension().is_some_and(|end| EXTENSIONS.iter().any(|own| end == *own)))
            .filter_map(|entry| {
                let metadata = entry.metadata().ok()?;
                Some((metadata.modified().ok()?, metadata.len(), entry.path()))
            })
            .collect();
        entries.sort();
        let mut all: u64 = bytes + entries.iter().map(|(_, size, _)| size).sum::<u64>();
        for (_, size, path) in entries {
            if all <= self.limit {
                return;
            }
            let _ = std::fs::remove_file(path);
            all -= size;
        }
    }
}

/// What is known of an object.
pub(crate) enum Claim<'c> {
    /// All.
    Known(Arc<DistanceObject>),
    /// Nothing: it is for the caller to measure.
    Open(Task<'c>),
}

/// An object to be measured. Others wait for it until this is dropped.
pub(crate) struct Task<'c> {
    cache: &'c Cache,
    path: PathBuf,
    _lock: Option<FileLock>,
}

impl Task<'_> {
    /// Keeps what was measured, if it is worth it.
    pub fn done(&self, measured: &Measured) {
        if measured.object.report().samples >= WORTH {
            self.cache.write(&self.path, measured.object.to_bytes());
        }
    }
}

/// The bytes before their own SHA-256, where they are what was written.
fn sound(bytes: &[u8]) -> Option<&[u8]> {
    let (bytes, sum) = bytes.split_at_checked(bytes.len().checked_sub(32)?)?;
    (Sha256::digest(bytes)[..] == *sum).then_some(bytes)
}
