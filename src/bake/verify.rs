//! A folder held against its manifests and records.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;

use super::claim::manifest_lock;
use super::done::{Difference, compare};
use super::manifest::{Known, Manifest};
use super::record::{Record, RecordFile};
use super::sealed::{self, SealedError};
use super::sequence::{Sequence, is_any_record, is_manifest};
use super::{Identity, Interrupt, output};
use crate::disk;

/// Something that is not as it should be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// The frame; `None` for what is no frame's.
    pub frame: Option<i64>,
    /// The file.
    pub path: PathBuf,
    /// What is wrong, and what to do about it.
    pub problem: String,
    /// Whether `bake` with `--resume` makes it as it should be.
    #[serde(skip)]
    pub resumes: bool,
}

/// What a sequence is like.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// The folder and the frame pattern.
    pub sequence: String,
    /// How many frames there should be: asked for or written.
    pub frames: usize,
    /// Bytes of the frames that are whole.
    pub bytes: u64,
    /// What is wrong.
    pub findings: Vec<Finding>,
}

/// The sequences of a folder whose manifests or records stand there, and what was found about files that tell of none.
///
/// # Errors
/// When the folder cannot be read.
pub fn sequences(folder: &Path) -> Result<(Vec<Sequence>, Vec<Finding>), SealedError> {
    let unreadable = |error| SealedError::System(folder.into(), error);
    let mut patterns: BTreeMap<String, Sequence> = BTreeMap::new();
    let mut damaged = Vec::new();
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        names.extend(entry.map_err(unreadable)?.file_name().into_string());
    }
    names.sort();
    for name in names {
        let path = folder.join(&name);
        let pattern = if is_manifest(&name) {
            sealed::read::<Manifest>(&path).map(|manifest| manifest.map(|manifest| manifest.pattern))
        } else if is_any_record(&name) {
            sealed::read::<RecordFile>(&path).map(|record| record.map(|record| record.pattern))
        } else {
            continue;
        };
        match pattern {
            Ok(None) => {}
            Ok(Some(pattern)) => {
                let parsed = output::pattern(&folder.join(&pattern));
                let parsed = parsed.map_err(|error| SealedError::Damaged(path, error.to_string()))?;
                patterns.insert(pattern, Sequence { pattern: parsed });
            }
            // Other programs have manifests, too.
            Err(_) if !disk::read(&path).is_ok_and(|bytes| holds(&bytes, b"hfvdb")) => {}
            Err(error) => damaged.push((name, Finding { path, ..self::damaged(&error) })),
        }
    }
    let sequences: Vec<Sequence> = patterns.into_values().collect();
    // A damaged file of a sequence that is known is found there.
    let known = |name: &str| {
        sequences.iter().any(|sequence| {
            sequence.is_record(name) || sequence.manifest().file_name().is_some_and(|manifest| manifest == name)
        })
    };
    let unknown = damaged.into_iter().filter(|(name, _)| !known(name)).map(|(_, finding)| finding).collect();
    Ok((sequences, unknown))
}

fn holds(bytes: &[u8], part: &[u8]) -> bool {
    bytes.windows(part.len()).any(|window| window == part)
}

fn advised(error: &SealedError) -> String {
    let advice = match error {
        SealedError::System(..) => "",
        SealedError::Damaged(path, _) if is_any_record(&path.file_name().unwrap_or_default().to_string_lossy()) => {
            "; delete it and bake its frame again with --resume"
        }
        SealedError::Damaged(..) => "; delete it, and verify makes it anew from the records",
    };
    // The path stands in front already.
    let text = error.to_string();
    let problem = text.split_once(": ").map_or(text.as_str(), |(_, problem)| problem);
    format!("{problem}{advice}")
}

/// Holds a sequence against its manifest and records, and writes the manifest anew where the records tell more than it
/// does. `Ok(None)` after an interruption.
///
/// # Errors
/// When the folder cannot be read, or nothing is known of the sequence.
pub fn verify(sequence: &Sequence, interrupt: &Interrupt) -> Result<Option<Verdict>, SealedError> {
    let mut findings = Vec::new();
    let known = match Known::read(sequence) {
        Err(error @ SealedError::Damaged(..)) => {
            findings.push(Finding { path: sequence.manifest(), ..damaged(&error) });
            Known::with_manifest(sequence, None)?
        }
        known => known?,
    };
    let Some(head) = known.head(sequence) else {
        if findings.is_empty() && known.damaged.is_empty() {
            let problem = "nothing is known of these frames: there is no manifest and no record of this name; \
                give the folder, or the name that they were baked to, such as frame.####.vdb";
            return Err(SealedError::System(sequence.display().into(), std::io::Error::other(problem)));
        }
        findings.extend(known.damaged.iter().map(damaged));
        return Ok(Some(Verdict { sequence: sequence.display(), frames: 0, bytes: 0, findings }));
    };
    let most = most(&known, &head.identity);
    let Some(frames) = frames(sequence, &known, most, interrupt) else { return Ok(None) };
    let bytes = frames.iter().map(|(whole, _)| whole).sum();
    let mut count = known.frames.values().map(|(_, record)| record.frames.len().max(1)).sum();
    findings.extend(frames.into_iter().filter_map(|(_, finding)| finding));
    findings.extend(known.damaged.iter().map(damaged));
    let asked = head.asked_frames();
    for &frame in &asked {
        let name = sequence.file_name(frame);
        if !known.frames.contains_key(&name) {
            count += 1;
            let path = sequence.pattern.file(frame);
            if path.symlink_metadata().is_err() {
                let problem = "missing: it was never finished".into();
                findings.push(Finding { frame: Some(frame), path, problem, resumes: true });
            }
        }
    }
    findings.extend(foreign(sequence, &known, &asked)?);
    findings.sort_by_key(|finding| finding.frame);
    if known.manifest.is_some() || !sequence.manifest().exists() {
        renew(sequence);
    }
    Ok(Some(Verdict { sequence: sequence.display(), frames: count, bytes, findings }))
}

/// What most frames were baked from: those of another bake are the fewer. As many of one as of another: the last bake's.
fn most<'a>(known: &'a Known, last: &'a Identity) -> &'a Identity {
    let mut counts: Vec<(&Identity, usize)> = vec![(last, 0)];
    for (identity, _) in known.frames.values() {
        match counts.iter_mut().find(|(counted, _)| *counted == identity) {
            Some((_, count)) => *count += 1,
            None => counts.push((identity, 1)),
        }
    }
    // The first of the greatest.
    counts.iter().rev().max_by_key(|(_, count)| *count).map_or(last, |(identity, _)| *identity)
}

/// The frames that are known: how many bytes of each are whole, and what is wrong.
fn frames(
    sequence: &Sequence,
    known: &Known,
    identity: &Identity,
    interrupt: &Interrupt,
) -> Option<Vec<(u64, Option<Finding>)>> {
    let one = |(theirs, record): &(Identity, Record)| {
        let path = sequence.folder().join(&record.file);
        let wrong = |problem: String| {
            let path = sequence.pattern.folder().join(&record.file);
            (0, Some(Finding { frame: Some(record.frame), path, problem, resumes: true }))
        };
        Some(match compare(&path, record, interrupt)? {
            Some(Difference::Missing) => wrong("missing".into()),
            Some(Difference::Changed(how)) => wrong(format!("changed: {how}")),
            None if theirs != identity => wrong(format!(
                "of another bake than most: {}; bake it with --resume as those were, or all as this one was",
                theirs.differences(identity)
            )),
            None => (record.bytes, None),
        })
    };
    known.frames.par_iter().map(|(_, frame)| one(frame)).collect()
}

fn damaged(error: &SealedError) -> Finding {
    let (SealedError::System(path, _) | SealedError::Damaged(path, _)) = error;
    let of_record = is_any_record(&path.file_name().unwrap_or_default().to_string_lossy());
    let resumes = of_record && matches!(error, SealedError::Damaged(..));
    Finding { frame: None, path: path.clone(), problem: advised(error), resumes }
}

/// Files that fit the pattern and that nothing is known of.
fn foreign(sequence: &Sequence, known: &Known, asked: &[i64]) -> Result<Vec<Finding>, SealedError> {
    let names = sequence.names()?;
    let foreign = names.iter().filter(|name| !known.frames.contains_key(*name)).filter_map(|name| {
        let frame = sequence.pattern.frame_of(name)?;
        let path = sequence.pattern.folder().join(name);
        // A bake replaces none but the frames that it is asked for.
        let resumes = asked.contains(&frame);
        let problem = if resumes {
            "foreign: a frame of this name that has no record; bake it with --resume"
        } else {
            "foreign: a frame that no bake was asked for and that has no record; take it away"
        };
        Some(Finding { frame: Some(frame), path, problem: problem.into(), resumes })
    });
    Ok(foreign.collect())
}

/// Writes the manifest anew where the records tell more. A folder that takes no files stays as it is.
fn renew(sequence: &Sequence) {
    let Ok(_lock) = manifest_lock(sequence, &Interrupt::default()) else { return };
    let Ok(known) = Known::read(sequence) else { return };
    let Some(head) = known.head(sequence) else { return };
    let manifest = known.assemble(&head);
    if known.manifest.as_ref() != Some(&manifest) {
        let _ = sealed::write(&sequence.manifest(), &manifest);
    }
}
