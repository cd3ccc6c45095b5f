//! One file that holds several frames by time. Its frames are baked as files of their own in a hidden folder beside it, as
//! those of any sequence, so that a job that was stopped goes on from there; once all are there they are joined, and the
//! folder goes.

use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

use super::done::compare;
use super::identity::Identity;
use super::manifest::{Known, Manifest};
use super::record::{Record, RecordFile};
use super::refusal::Refusal;
use super::run::{Existing, Output};
use super::sealed::{self, SealedError, hexadecimal};
use super::sequence::Sequence;
use super::wish::Wish;
use super::{Error, FramePattern, Interrupt, PatternError};
use crate::disk::{self, FileLock};
use crate::node::Model;
use crate::text::frames::in_ranges;

/// What the name of the hidden folder ends in.
const FOLDER: &str = ".hfvdb-frames";

/// A file of several frames, and where these are on their way.
pub struct Whole {
    /// The file: its name has no frame token.
    pub sequence: Sequence,
    /// The files of its frames.
    pub frames: Sequence,
}

/// The right to write a file of several frames, which one process has at a time.
#[must_use = "others may write the file once this is gone"]
pub struct WholeLock {
    _frame: FileLock,
    _run: Option<FileLock>,
}

impl Whole {
    /// The file of a pattern that has no frame token.
    ///
    /// # Errors
    /// Where its frames can have no names.
    pub fn new(pattern: FramePattern) -> Result<Self, PatternError> {
        let file = pattern.file(0);
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let end = file.extension().unwrap_or_default().to_string_lossy().into_owned();
        let folder = pattern.folder().join(format!(".{name}{FOLDER}"));
        let frames = FramePattern::new(&folder.join(format!("frame.####.{end}")), &[])?;
        Ok(Self { sequence: Sequence { pattern }, frames: Sequence { pattern: frames } })
    }

    /// Where it is.
    pub fn path(&self) -> PathBuf {
        self.sequence.pattern.file(0)
    }

    /// Its record where it is what is wished for, and to be kept. `None` where it is to be written.
    ///
    /// # Errors
    /// Why it must not be.
    pub fn examine(&self, wish: &Wish, interrupt: &Interrupt) -> Result<Option<Record>, Refusal> {
        if self.path().symlink_metadata().is_err() || wish.existing == Existing::Overwrite {
            return Ok(None);
        }
        if wish.existing == Existing::Refuse {
            return Err(Refusal::Exist(self.path(), 1));
        }
        let Some((theirs, record)) = self.known()? else { return Ok(None) };
        if theirs.scene != wish.identity.scene {
            return Err(Refusal::OtherScene {
                sequence: self.sequence.display(),
                theirs: theirs.scene,
                ours: wish.identity.scene.clone(),
                at_work: false,
            });
        }
        let held: Vec<i64> = record.frames.iter().map(|frame| frame.frame).collect();
        let asked = wish.frames.numbers();
        if theirs == wish.identity && held.iter().any(|frame| !asked.contains(frame)) {
            return Err(Refusal::OtherFrames(self.path(), in_ranges(&held)));
        }
        if theirs != wish.identity || held != asked {
            return Ok(None);
        }
        match compare(&self.path(), &record, interrupt) {
            None => Err(Refusal::Interrupted),
            Some(None) => Ok(Some(record)),
            Some(Some(_)) => Ok(None),
        }
    }

    fn known(&self) -> Result<Option<(Identity, Record)>, Refusal> {
        let file = match sealed::read::<RecordFile>(&self.sequence.record(0)) {
            // Without a sound record it is a file of unknown making, as any.
            Err(SealedError::Damaged(..)) => None,
            file => file.map_err(Refusal::Damaged)?,
        };
        Ok(file.map(|file| (file.identity, file.record)))
    }

    /// Keeps other processes from the file.
    ///
    /// # Errors
    /// [`Refusal::AtWork`] where one is at it; when the system refuses.
    pub fn lock(&self) -> Result<WholeLock, Refusal> {
        let lock = FileLock::try_take(&self.sequence.frame_lock(0)).map_err(Refusal::Disk)?;
        let Some(frame) = lock else { return Err(Refusal::AtWork(self.path())) };
        if frame.enforced() {
            self.sweep();
        }
        let nanoseconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_nanos());
        let run = self.sequence.run_lock(&format!("{}-{nanoseconds}", std::process::id()));
        let run = FileLock::try_take(&run).map_err(Refusal::Disk)?;
        Ok(WholeLock { _frame: frame, _run: run })
    }

    /// Deletes what processes that were killed have left.
    fn sweep(&self) {
        let (folder, sequence) = (self.sequence.folder(), &self.sequence);
        for name in sequence.names().unwrap_or_default() {
            // What cannot be deleted holds nobody up.
            if sequence.is_temporary(&name) {
                let _ = std::fs::remove_file(folder.join(name));
            } else if sequence.is_run_lock(&name) {
                // Where its process is gone it is free, and goes when it is let go.
                drop(FileLock::try_take(&folder.join(name)));
            }
        }
    }

    /// Joins the frames with these records, rising, into the file, and takes their folder away. Of no more than one frame
    /// is more than a line in memory.
    ///
    /// # Errors
    /// When the system refuses, or after an interruption; the frames stay then.
    pub fn join(
        &self,
        model: &Model,
        output: &Output,
        wish: &Wish,
        records: &[Record],
        _lock: WholeLock,
        interrupt: &Interrupt,
    ) -> Result<(), Error> {
        let Some(join) = output.format.join() else {
            return Err(Error::Encode(format!("a .{} holds one frame", output.format.extension())));
        };
        let path = self.path();
        let frames: Vec<(i64, PathBuf)> =
            records.iter().map(|record| (record.frame, self.frames.pattern.file(record.frame))).collect();
        let staged = disk::stage_stream(&path, output.existing.replaces(), |out| {
            join(&super::output::Joining { model, output, path: &path, frames: &frames, interrupt }, out)
        })?;
        let written = staged.commit()?;
        self.record(wish, records, written).map_err(Error::from)?;
        // What cannot be deleted holds nobody up.
        let _ = std::fs::remove_dir_all(self.frames.folder());
        Ok(())
    }

    fn record(&self, wish: &Wish, records: &[Record], written: disk::Written) -> Result<(), disk::Error> {
        let (file, sha256) = (self.sequence.file_name(0), hexadecimal(&written.sha256));
        let of_frame = |record: &Record| Record { file: file.clone(), sha256: sha256.clone(), ..record.clone() };
        let frames: Vec<Record> = records.iter().map(of_frame).collect();
        let Some(first) = frames.first().cloned() else { return Ok(()) };
        let sum = |seconds: fn(&Record) -> f64| records.iter().map(seconds).sum();
        let record = Record {
            bytes: written.bytes,
            compute_seconds: sum(|record| record.compute_seconds),
            write_seconds: sum(|record| record.write_seconds),
            frames,
            ..first
        };
        let (pattern, identity) = (self.sequence.pattern.text(), wish.identity.clone());
        sealed::write(
            &self.sequence.record(0),
            &RecordFile { hfvdb_record: 1, pattern, identity: identity.clone(), record: record.clone() },
        )?;
        let known =
            Known { manifest: None, frames: [(record.file.clone(), (identity, record))].into(), damaged: vec![] };
        let head = Manifest::new(&self.sequence, wish.identity.clone(), wish.source.clone(), &wish.frames);
        sealed::write(&self.sequence.manifest(), &known.assemble(&head))
    }
}
