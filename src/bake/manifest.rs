//! What is known of a sequence: its manifest, and the records of its frames, which are newer.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::Existing;
use super::frames::Frames;
use super::identity::Identity;
use super::record::{Record, RecordFile};
use super::sealed::{self, SealedError};
use super::sequence::Sequence;

/// The document `NAME.manifest.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// The version of this shape: 1.
    pub hfvdb_manifest: u32,
    /// The frame pattern, without a folder.
    pub pattern: String,
    /// What the frames were baked from.
    pub identity: Identity,
    /// Where that came from, in the user's words.
    pub source: Source,
    /// The frames that were asked for, by any call: `1-48`.
    pub asked: String,
    /// The frames that were written.
    pub frames: Vec<Entry>,
}

/// A scene as the command line named it; its hash tells all of this apart, too.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Source {
    /// The scene's name or file.
    pub scene: String,
    /// The variant of it.
    pub variant: Option<String>,
    /// What was set.
    pub set: Vec<String>,
}

/// A frame in a manifest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Its record.
    #[serde(flatten)]
    pub record: Record,
    /// What it was baked from, where that is not what the manifest says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub identity: Option<Identity>,
}

/// What stands beside the frames of a sequence.
pub struct Known {
    /// The manifest as it stands.
    pub manifest: Option<Manifest>,
    /// For each file name, its record and what it was baked from.
    pub frames: BTreeMap<String, (Identity, Record)>,
    /// Records that cannot be taken as they are.
    pub damaged: Vec<SealedError>,
}

impl Known {
    /// Reads the manifest and all records. A damaged record is listed, a damaged manifest is an error.
    ///
    /// # Errors
    /// When the system refuses, or the manifest is not what was written.
    pub fn read(sequence: &Sequence) -> Result<Self, SealedError> {
        let manifest = sealed::read::<Manifest>(&sequence.manifest())?;
        Self::with_manifest(sequence, manifest)
    }

    /// As [`Self::read`]; who overwrites whatever there is needs no sound manifest.
    ///
    /// # Errors
    /// Those of [`Self::read`].
    pub fn for_bake(sequence: &Sequence, existing: Existing) -> Result<Self, SealedError> {
        match Self::read(sequence) {
            Err(_) if existing == Existing::Overwrite => Self::with_manifest(sequence, None),
            known => known,
        }
    }

    /// As [`Self::read`], without looking at the manifest that stands there.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn with_manifest(sequence: &Sequence, manifest: Option<Manifest>) -> Result<Self, SealedError> {
        let names = sequence.names()?;
        let paths = names.par_iter().filter(|name| sequence.is_record(name)).map(|name| sequence.folder().join(name));
        let read: Vec<_> = paths.filter_map(|path| sealed::read::<RecordFile>(&path).transpose()).collect();
        let mut frames = BTreeMap::new();
        if let Some(manifest) = &manifest {
            for Entry { record, identity } in &manifest.frames {
                let identity = identity.as_ref().unwrap_or(&manifest.identity);
                frames.insert(record.file.clone(), (identity.clone(), record.clone()));
            }
        }
        let mut damaged = Vec::new();
        for file in read {
            match file {
                // A single frame's name is a pattern, too, and its record another sequence's.
                Ok(file) if file.pattern != sequence.pattern.text() => {}
                Ok(file) => {
                    frames.insert(file.record.file.clone(), (file.identity, file.record));
                }
                Err(error) => damaged.push(error),
            }
        }
        Ok(Self { manifest, frames, damaged })
    }

    /// The manifest of all that is known, under a head.
    pub fn assemble(&self, head: &Manifest) -> Manifest {
        let mut frames: Vec<Entry> = self
            .frames
            .values()
            .map(|(identity, record)| Entry {
                record: record.clone(),
                identity: (*identity != head.identity).then(|| identity.clone()),
            })
            .collect();
        frames.sort_by_key(|entry| entry.record.frame);
        Manifest { frames, ..head.clone() }
    }

    /// A manifest's head, made of the records where there is none: the first frame's identity, and the frames known.
    pub fn head(&self, sequence: &Sequence) -> Option<Manifest> {
        if let Some(manifest) = &self.manifest {
            return Some(Manifest { frames: Vec::new(), ..manifest.clone() });
        }
        let (identity, _) = self.frames.values().min_by_key(|(_, record)| record.frame)?;
        let asked = Frames::of_numbers(self.frames.values().map(|(_, record)| record.frame))?;
        Some(Manifest::new(sequence, identity.clone(), Source::default(), &asked))
    }
}

impl Manifest {
    /// One without frames.
    pub fn new(sequence: &Sequence, identity: Identity, source: Source, asked: &Frames) -> Self {
        Self {
            hfvdb_manifest: 1,
            pattern: sequence.pattern.text(),
            identity,
            source,
            asked: asked.to_string(),
            frames: Vec::new(),
        }
    }

    /// The frames that were asked for.
    pub fn asked_frames(&self) -> Vec<i64> {
        self.asked.parse::<Frames>().map(|frames| frames.numbers().to_vec()).unwrap_or_default()
    }
}
