//! Why frames may not be written where they should.

use std::fmt;
use std::path::PathBuf;

use super::Existing;
use super::manifest::Known;
use super::sealed::SealedError;
use super::sequence::Sequence;
use super::wish::Wish;
use crate::disk;
use crate::terminal;

/// Why a sequence cannot be written.
#[derive(Debug)]
pub enum Refusal {
    /// Files that exist, the first of them named.
    Exist(PathBuf, usize),
    /// The sequence holds frames of another scene.
    OtherScene {
        /// The sequence.
        sequence: String,
        /// The hash of the scene there.
        theirs: String,
        /// The hash of the scene that was to be baked.
        ours: String,
        /// Whether another process bakes it now.
        at_work: bool,
    },
    /// The sequence holds frames of the same scene with other options.
    OtherOptions {
        /// The sequence.
        sequence: String,
        /// The differences, in words.
        differences: String,
        /// Whether another process bakes it now.
        at_work: bool,
    },
    /// The file holds frames that were not asked for.
    OtherFrames(PathBuf, String),
    /// The manifest is that of another pattern.
    OtherPattern(PathBuf, String),
    /// The manifest or a record is not what was written, or cannot be read.
    Damaged(SealedError),
    /// Another process writes the same file of several frames.
    AtWork(PathBuf),
    /// Another process holds a lock for too long.
    Busy(PathBuf),
    /// The system refused.
    Disk(disk::Error),
    /// The caller raised the [`Interrupt`](super::Interrupt).
    Interrupted,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const WAY_OUT: &str = "replace them with --overwrite, or choose another name";
        let while_baked = |at_work: bool| {
            if at_work { "another process bakes them now: wait for it, or choose another name" } else { WAY_OUT }
        };
        match self {
            Self::Exist(path, 1) => write!(
                f,
                "{} exists; keep it if it is done with --resume, replace it with --overwrite, or choose another name",
                terminal::path(path)
            ),
            Self::Exist(path, count) => write!(
                f,
                "{} exists, and {} more of the files to write; keep those that are done with --resume, \
                 replace all with --overwrite, or choose another name",
                terminal::path(path),
                count - 1
            ),
            Self::OtherScene { sequence, theirs, ours, at_work } => write!(
                f,
                "{sequence} holds frames of another scene: the hash of theirs is {theirs}, of this one {ours}; {}",
                while_baked(*at_work)
            ),
            Self::OtherOptions { sequence, differences, at_work } => write!(
                f,
                "{sequence} holds frames of this scene that were baked otherwise: {differences}; {}",
                while_baked(*at_work)
            ),
            Self::OtherFrames(path, held) => write!(
                f,
                "{} holds frames {held}, and not all of them were asked for; ask for all, {WAY_OUT}",
                terminal::path(path)
            ),
            Self::OtherPattern(path, pattern) => write!(
                f,
                "{}: this is the manifest of {pattern} in the same folder; choose another name or another folder",
                terminal::path(path)
            ),
            Self::Damaged(error @ SealedError::Damaged(..)) => write!(
                f,
                "{error}; delete it and run the command again: a manifest is made anew from the records, and a frame \
                 without a record is baked again by --resume"
            ),
            Self::Damaged(error) => error.fmt(f),
            Self::AtWork(path) => write!(
                f,
                "{}: another process writes this file now; wait for it, or choose another name",
                terminal::path(path)
            ),
            Self::Busy(path) => {
                write!(
                    f,
                    "{}: another process has held this lock for a minute; look what it does",
                    terminal::path(path)
                )
            }
            Self::Disk(error) => error.fmt(f),
            Self::Interrupted => f.write_str("interrupted"),
        }
    }
}

impl std::error::Error for Refusal {}

/// Why a wish is refused, judged by what is known of the sequence. `at_work`: others bake it now.
pub fn refusal(sequence: &Sequence, known: &Known, wish: &Wish, at_work: bool) -> Option<Refusal> {
    // Frames that somebody deleted hold nobody up, nor does what is left of their manifest.
    let there = |file: &str| sequence.folder().join(file).symlink_metadata().is_ok();
    let standing: Vec<_> = known.frames.iter().filter(|(file, _)| there(file)).map(|(_, (theirs, _))| theirs).collect();
    let claims = at_work || !standing.is_empty();
    let head = known.manifest.as_ref().filter(|_| claims);
    if let Some(manifest) = head.filter(|manifest| manifest.pattern != sequence.pattern.text()) {
        return Some(Refusal::OtherPattern(sequence.manifest(), manifest.pattern.clone()));
    }
    let head = head.map(|manifest| &manifest.identity);
    // Who resumes replaces single frames of others, not whole sequences; who overwrites replaces whatever there is,
    // but nothing that is being made.
    let binding: Vec<_> = match wish.existing {
        Existing::Refuse => head.into_iter().chain(standing).collect(),
        Existing::Resume => head.into_iter().collect(),
        Existing::Overwrite => head.into_iter().filter(|_| at_work).collect(),
    };
    let ours = &wish.identity;
    if let Some(theirs) = binding.iter().find(|theirs| theirs.scene != ours.scene) {
        let (theirs, ours) = (theirs.scene.clone(), ours.scene.clone());
        return Some(Refusal::OtherScene { sequence: sequence.display(), theirs, ours, at_work });
    }
    if wish.existing == Existing::Refuse {
        let files = wish.frames.numbers().iter().map(|&frame| sequence.pattern.file(frame));
        let exist: Vec<_> = files.filter(|file| file.symlink_metadata().is_ok()).collect();
        // While others bake the same frames, those that they have finished are taken as they are.
        let theirs = |file: &PathBuf| {
            let name = file.file_name().and_then(|name| name.to_str()).unwrap_or_default();
            at_work && known.frames.get(name).is_some_and(|(identity, _)| identity == ours)
        };
        let exist: Vec<_> = exist.into_iter().filter(|file| !theirs(file)).collect();
        if let Some(first) = exist.first() {
            return Some(Refusal::Exist(first.clone(), exist.len()));
        }
    }
    let options_bind = at_work || wish.existing == Existing::Refuse;
    let other = binding.iter().find(|theirs| options_bind && **theirs != ours);
    other.map(|theirs| Refusal::OtherOptions {
        sequence: sequence.display(),
        differences: theirs.differences(ours),
        at_work,
    })
}
