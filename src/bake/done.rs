//! Whether a frame is done: judged by the content of its file, never by a name alone.

use std::io::{self, Read};
use std::path::Path;

use rayon::prelude::*;
use sha2::{Digest, Sha256};

use super::Interrupt;
use super::identity::Identity;
use super::manifest::Known;
use super::record::Record;
use super::sealed::hexadecimal;
use super::sequence::Sequence;
use crate::disk;
use crate::text::frames::in_ranges;

/// What stands under the name of a frame.
#[derive(Clone, Debug, PartialEq)]
pub enum State {
    /// The frame, as it was written.
    Done(Box<Record>),
    /// No file.
    Missing,
    /// A file that nothing is known of.
    Unknown,
    /// One file of several frames, these.
    Several(String),
    /// A frame of another scene, or with other options: in words.
    Other(String),
    /// A file that is not what was written: in words.
    Changed(String),
}

/// Judges a frame's file by what is known of it. `None` after an interruption.
pub fn judge(
    path: &Path,
    frame: i64,
    known: Option<&(Identity, Record)>,
    identity: &Identity,
    interrupt: &Interrupt,
) -> Option<State> {
    if path.symlink_metadata().is_err() {
        return Some(State::Missing);
    }
    let Some((theirs, record)) = known else { return Some(State::Unknown) };
    if theirs != identity {
        return Some(State::Other(theirs.differences(identity)));
    }
    if !record.frames.is_empty() {
        let frames: Vec<i64> = record.frames.iter().map(|frame| frame.frame).collect();
        return Some(State::Several(in_ranges(&frames)));
    }
    if record.frame != frame {
        return Some(State::Other(format!("it is frame {}", record.frame)));
    }
    Some(match compare(path, record, interrupt)? {
        None => State::Done(Box::new(record.clone())),
        Some(Difference::Missing) => State::Missing,
        Some(Difference::Changed(how)) => State::Changed(how),
    })
}

/// How a file differs from its record.
pub enum Difference {
    /// It is not there.
    Missing,
    /// It is not what was written.
    Changed(String),
}

/// Compares a file with its record; `Some(None)` where they agree, `None` after an interruption.
pub fn compare(path: &Path, record: &Record, interrupt: &Interrupt) -> Option<Option<Difference>> {
    let changed = |how: String| Some(Some(Difference::Changed(how)));
    match std::fs::metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Some(Some(Difference::Missing)),
        Err(error) => return changed(format!("it cannot be read: {error}")),
        Ok(metadata) if !metadata.is_file() => return changed("it is no file".into()),
        Ok(metadata) if metadata.len() != record.bytes => {
            return changed(format!("it has {} bytes, {} were written", metadata.len(), record.bytes));
        }
        Ok(_) => {}
    }
    match sha256(path, interrupt) {
        Err(error) => changed(format!("it cannot be read: {error}")),
        Ok(None) => None,
        Ok(Some(sha256)) if sha256 == record.sha256 => Some(None),
        Ok(Some(_)) => changed("its content is not what was written (SHA-256)".into()),
    }
}

/// SHA-256 of a file, in hexadecimal; `None` after an interruption.
fn sha256(path: &Path, interrupt: &Interrupt) -> io::Result<Option<String>> {
    let mut file = disk::open(path)?;
    let mut digest = Sha256::new();
    let mut buffer = vec![0; 1 << 20];
    loop {
        if interrupt.is_raised() {
            return Ok(None);
        }
        match file.read(&mut buffer)? {
            0 => return Ok(Some(hexadecimal(&digest.finalize()))),
            count => digest.update(&buffer[..count]),
        }
    }
}

/// Judges the frames of a sequence, on all threads. `None` after an interruption.
pub fn judge_all(
    sequence: &Sequence,
    frames: &[i64],
    known: &Known,
    identity: &Identity,
    interrupt: &Interrupt,
) -> Option<Vec<(i64, State)>> {
    let one = |&frame: &i64| {
        let known = known.frames.get(&sequence.file_name(frame));
        Some((frame, judge(&sequence.pattern.file(frame), frame, known, identity, interrupt)?))
    };
    frames.par_iter().map(one).collect()
}
