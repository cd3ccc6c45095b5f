//! Who may write frames of a sequence: settled before any work, and kept while the work lasts.

use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use super::Interrupt;
use super::frames::Frames;
use super::identity::Identity;
use super::manifest::{Known, Manifest};
use super::refusal::{Refusal, refusal};
use super::sealed;
use super::sequence::Sequence;
use super::wish::Wish;
use crate::disk::FileLock;

/// How long the manifest's lock may be held by others, who need it for fractions of a second.
const PATIENCE: Duration = Duration::from_secs(60);

/// The right to write frames of a sequence, shared with bakes of the same scene and options. Given up on every orderly
/// end: locks and temporaries go, and the manifest tells what there is.
pub struct Claim {
    /// What was known when it was taken.
    pub known: Known,
    /// What to tell the user.
    pub warnings: Vec<String>,
    sequence: Sequence,
    head: Manifest,
    before: Option<Manifest>,
    run_lock: Option<FileLock>,
}

impl Claim {
    /// Takes a claim, or says why it cannot be had. Writes the manifest, so that others see it.
    ///
    /// # Errors
    /// Those of [`refusal`]; when the system refuses.
    pub fn take(sequence: &Sequence, wish: &Wish, interrupt: &Interrupt) -> Result<Self, Refusal> {
        let lock = manifest_lock(sequence, interrupt)?;
        let alone = alone(sequence, &lock)?;
        let mut known = Known::for_bake(sequence, wish.existing).map_err(Refusal::Damaged)?;
        if let Some(refusal) = refusal(sequence, &known, wish, !alone) {
            return Err(refusal);
        }
        if alone {
            sweep(sequence, &lock);
            forget(sequence, &mut known, &wish.identity);
        }
        let nanoseconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_nanos());
        let run_lock = sequence.run_lock(&format!("{}-{nanoseconds}", std::process::id()));
        let run_lock = FileLock::try_take(&run_lock).map_err(Refusal::Disk)?;
        let head = head(sequence, &known, wish);
        let mut warnings: Vec<String> =
            known.damaged.iter().map(|damaged| format!("{damaged}; its frame is taken as not baked")).collect();
        if !lock.enforced() {
            warnings.push("this file system has no file locks: let no two processes bake the same frames".into());
        }
        let before = known.manifest.clone();
        sealed::write(&sequence.manifest(), &known.assemble(&head)).map_err(Refusal::Disk)?;
        Ok(Self { known, warnings, sequence: sequence.clone(), head, before, run_lock })
    }

    /// Gives the claim up, with all frames in the manifest.
    ///
    /// # Errors
    /// When the system refuses; the records hold the same.
    pub fn finish(mut self) -> Result<(), Refusal> {
        self.end()
    }

    fn end(&mut self) -> Result<(), Refusal> {
        let Some(run_lock) = self.run_lock.take() else { return Ok(()) };
        let sequence = &self.sequence;
        let lock = manifest_lock(sequence, &Interrupt::default())?;
        drop(run_lock);
        let alone = alone(sequence, &lock)?;
        if alone {
            sweep(sequence, &lock);
        }
        let known = Known::read(sequence).map_err(Refusal::Damaged)?;
        // Other calls may have asked for more frames meanwhile, or have overwritten the sequence.
        let mut head = known.manifest.as_ref().unwrap_or(&self.head);
        let ours = known.frames.values().any(|(identity, _)| *identity == self.head.identity);
        if alone && !ours && head.identity == self.head.identity {
            // Not one frame came of it: all is as it was.
            let Some(before) = &self.before else {
                let _ = std::fs::remove_file(sequence.manifest());
                return Ok(());
            };
            head = before;
        }
        sealed::write(&sequence.manifest(), &known.assemble(head)).map_err(Refusal::Disk)
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        // After an error, which says more than this one would.
        let _ = self.end();
    }
}

/// The head of the manifest from now on: frames asked for by other calls for the same scene stay asked for.
fn head(sequence: &Sequence, known: &Known, wish: &Wish) -> Manifest {
    let mut asked = wish.frames.clone();
    let before = known.manifest.as_ref().filter(|before| before.identity.scene == wish.identity.scene);
    if let Some(before) = before.filter(|_| sequence.pattern.has_token()) {
        let all = before.asked_frames().into_iter().chain(asked.numbers().iter().copied());
        asked = Frames::of_numbers(all).unwrap_or(asked);
    }
    Manifest::new(sequence, wish.identity.clone(), wish.source.clone(), &asked)
}

/// The manifest's lock, waited for.
pub(super) fn manifest_lock(sequence: &Sequence, interrupt: &Interrupt) -> Result<FileLock, Refusal> {
    let start = Instant::now();
    loop {
        if let Some(lock) = FileLock::try_take(&sequence.manifest_lock()).map_err(Refusal::Disk)? {
            return Ok(lock);
        }
        if interrupt.is_raised() {
            return Err(Refusal::Interrupted);
        }
        if start.elapsed() > PATIENCE {
            return Err(Refusal::Busy(sequence.manifest_lock()));
        }
        thread::sleep(Duration::from_millis(20));
    }
}

/// Whether no process bakes frames of the sequence. Locks of processes that are no more are deleted on the way. Asked
/// under the manifest's lock, under which alone such locks are made.
fn alone(sequence: &Sequence, lock: &FileLock) -> Result<bool, Refusal> {
    let mut alone = lock.enforced();
    for name in sequence.names().map_err(Refusal::Damaged)?.iter().filter(|name| sequence.is_run_lock(name)) {
        let lock = FileLock::try_take(&path(sequence, name)).map_err(Refusal::Disk)?;
        alone &= lock.is_some();
    }
    Ok(alone)
}

/// Deletes what processes that were killed have left.
fn sweep(sequence: &Sequence, _alone: &FileLock) {
    for name in sequence.names().unwrap_or_default().iter().filter(|name| sequence.is_leftover(name)) {
        // What cannot be deleted holds nobody up.
        let _ = std::fs::remove_file(path(sequence, name));
    }
}

/// Forgets frames of other bakes whose files somebody has deleted.
fn forget(sequence: &Sequence, known: &mut Known, ours: &Identity) {
    known.frames.retain(|file, (theirs, record)| {
        let keep = theirs == ours || path(sequence, file).symlink_metadata().is_ok();
        if !keep {
            let _ = std::fs::remove_file(sequence.record(record.frame));
        }
        keep
    });
}

fn path(sequence: &Sequence, name: &str) -> PathBuf {
    Path::new(sequence.folder()).join(name)
}
