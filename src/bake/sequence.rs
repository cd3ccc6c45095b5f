//! The files of a sequence: frames, and what stands beside them in the same folder.
//!
//! Of `out/m.####.vdb`: the manifest `m.manifest.json`; of frame 7 the record `.m.0007.hfvdb-record.json` and, while
//! it is baked, the lock `.m.0007.hfvdb-lock`; while a process bakes any frame `.m.PROCESS.hfvdb-run-lock`; while the
//! manifest is rewritten `.m.hfvdb-manifest-lock`. Programs that list a sequence see the frames alone. Where frames are other
//! files than `.vdb` their ending is part of these names, so that both kinds may stand in one folder.

use std::io;
use std::path::{Path, PathBuf};

use super::FramePattern;
use super::sealed::SealedError;
use crate::disk::temporary_target;

const RECORD: &str = ".hfvdb-record.json";
const FRAME_LOCK: &str = ".hfvdb-lock";
const RUN_LOCK: &str = ".hfvdb-run-lock";
const MANIFEST: &str = ".manifest.json";
/// The most bytes of a frame's name: its record's and temporaries' are longer, and file systems take 255.
const LONGEST_NAME: usize = 200;

/// A frame pattern with the names of all that belongs to it.
#[derive(Clone, Debug)]
pub struct Sequence {
    /// Its frames.
    pub pattern: FramePattern,
}

impl Sequence {
    /// The folder, never empty.
    pub fn folder(&self) -> &Path {
        if self.pattern.folder().as_os_str().is_empty() { Path::new(".") } else { self.pattern.folder() }
    }

    /// The ending of frames, where that is part of the names of what stands beside them.
    fn ending(&self) -> Option<String> {
        let name = self.file_name(0);
        let (_, ending) = name.rsplit_once('.')?;
        (!ending.eq_ignore_ascii_case("vdb")).then(|| ending.to_owned())
    }

    /// What names of files for all frames begin with.
    fn name(&self) -> String {
        match self.ending() {
            Some(ending) => format!("{}.{ending}", self.pattern.name()),
            None => self.pattern.name(),
        }
    }

    fn beside(&self, name: &str) -> PathBuf {
        self.pattern.folder().join(name)
    }

    /// As people write it: the folder and the pattern.
    pub fn display(&self) -> String {
        self.beside(&self.pattern.text()).display().to_string()
    }

    /// The manifest of all frames.
    pub fn manifest(&self) -> PathBuf {
        self.beside(&format!("{}{MANIFEST}", self.name()))
    }

    /// The name of a frame's file.
    pub fn file_name(&self, frame: i64) -> String {
        self.pattern.file(frame).file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
    }

    /// The record of a frame.
    pub fn record(&self, frame: i64) -> PathBuf {
        self.hidden(frame, RECORD)
    }

    /// The lock of a frame that is being baked.
    pub fn frame_lock(&self, frame: i64) -> PathBuf {
        self.hidden(frame, FRAME_LOCK)
    }

    /// The lock under which the manifest is read and rewritten.
    pub fn manifest_lock(&self) -> PathBuf {
        self.beside(&format!(".{}.hfvdb-manifest-lock", self.name()))
    }

    /// The lock of one process that bakes frames of this sequence.
    pub fn run_lock(&self, process: &str) -> PathBuf {
        self.beside(&format!(".{}.{process}{RUN_LOCK}", self.name()))
    }

    fn hidden(&self, frame: i64, suffix: &str) -> PathBuf {
        let name = self.file_name(frame);
        let stem = match name.rsplit_once('.') {
            Some((stem, _)) if self.ending().is_none() => stem,
            _ => name.as_str(),
        };
        self.beside(&format!(".{stem}{suffix}"))
    }

    /// Whether a name is that of a frame's record.
    pub fn is_record(&self, name: &str) -> bool {
        self.is_hidden(name, RECORD)
    }

    fn is_hidden(&self, name: &str, suffix: &str) -> bool {
        let extension = self.file_name(0).rsplit_once('.').map(|(_, extension)| extension.to_owned());
        let stem = name.strip_prefix('.').and_then(|name| name.strip_suffix(suffix));
        let (Some(stem), Some(extension)) = (stem, extension) else { return false };
        if self.ending().is_some() {
            return self.pattern.frame_of(stem).is_some();
        }
        self.pattern.frame_of(&format!("{stem}.{extension}")).is_some()
    }

    /// Whether a name is that of a process's lock.
    pub fn is_run_lock(&self, name: &str) -> bool {
        let start = format!(".{}.", self.name());
        let process = name.strip_prefix(&start).and_then(|rest| rest.strip_suffix(RUN_LOCK));
        process.is_some_and(|process| !process.contains('.'))
    }

    /// Whether a name is that of a lock of a frame or a temporary: left behind, where nobody is at work.
    pub fn is_leftover(&self, name: &str) -> bool {
        self.is_hidden(name, FRAME_LOCK) || self.is_temporary(name)
    }

    /// Whether a name is that of a file on its way to a name of this sequence.
    pub fn is_temporary(&self, name: &str) -> bool {
        temporary_target(name).is_some_and(|target| {
            self.pattern.frame_of(target).is_some()
                || self.is_record(target)
                || self.manifest().file_name().is_some_and(|manifest| manifest == target)
        })
    }

    /// The names in the folder; none where it is not there.
    ///
    /// # Errors
    /// When the system refuses to list them.
    pub fn names(&self) -> Result<Vec<String>, SealedError> {
        let unreadable = |error| SealedError::System(self.folder().into(), error);
        let entries = match std::fs::read_dir(self.folder()) {
            Ok(entries) => entries,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => return Err(unreadable(error)),
        };
        // Names that are not UTF-8 are none of ours.
        let names = entries.map(|entry| Ok(entry?.file_name().into_string().ok()));
        let mut names: Vec<String> =
            names.filter_map(io::Result::transpose).collect::<io::Result<_>>().map_err(unreadable)?;
        names.sort();
        Ok(names)
    }

    /// Whether names get too long for files beside the frames.
    pub fn name_is_too_long(&self) -> bool {
        self.file_name(-999_999_999).len() > LONGEST_NAME
    }
}

/// The patterns of a folder's sequences whose manifests have these names.
pub fn is_manifest(name: &str) -> bool {
    name.ends_with(MANIFEST) && !name.starts_with('.')
}

/// Whether a name is that of a record of any sequence.
pub fn is_any_record(name: &str) -> bool {
    name.starts_with('.') && name.ends_with(RECORD)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_belongs_to_a_sequence() {
        let pattern = |text: &str| FramePattern::new(Path::new(text), &["vdb"]).unwrap();
        let m = Sequence { pattern: pattern("out/m.####.vdb") };
        assert_eq!(m.manifest(), Path::new("out/m.manifest.json"));
        assert_eq!(m.record(7), Path::new("out/.m.0007.hfvdb-record.json"));
        assert!(m.is_record(".m.0007.hfvdb-record.json") && !m.is_record(".n.0007.hfvdb-record.json"));
        assert!(m.is_run_lock(".m.12-34.hfvdb-run-lock") && !m.is_run_lock(".m.v2.12-34.hfvdb-run-lock"));
        for name in [
            ".m.0007.hfvdb-lock",
            ".m.0007.vdb.abc123.hfvdb-tmp",
            "..m.0007.hfvdb-record.json.abc123.hfvdb-tmp",
            ".m.manifest.json.abc123.hfvdb-tmp",
        ] {
            assert!(m.is_leftover(name), "{name}");
        }
        for name in ["m.0007.vdb", ".n.0007.vdb.abc123.hfvdb-tmp", ".m.0007.hfvdb-record.json", "m.manifest.json"] {
            assert!(!m.is_leftover(name), "{name}");
        }
        let still = Sequence { pattern: pattern("heart.vdb") };
        assert_eq!(still.record(1), Path::new(".heart.hfvdb-record.json"));
        assert!(still.is_leftover(".heart.vdb.abc123.hfvdb-tmp") && !still.is_leftover(".m.0007.hfvdb-lock"));
    }
}
