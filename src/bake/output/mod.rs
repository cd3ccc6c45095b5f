//! What a frame's file can be: one format, one file here and one row of [`FORMATS`].
//!
//! A format turns a computed frame into bytes. That these become a file which is whole, and whether a file is still what
//! was written, is the same for all.

mod glb;
mod naming;
mod nvdb;
mod obj;
mod ply;
mod polygons;
mod usda;
mod vdb;

use std::fmt;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::{Computed, Error, FramePattern, Interrupt, Output, PatternError, PolygonRecord};
use crate::node::Model;
use crate::shot::Prepared;

/// All formats; the first is the one that messages propose.
pub static FORMATS: [&dyn Format; 6] = [&vdb::Vdb, &nvdb::Nvdb, &glb::Glb, &usda::Usda, &ply::Ply, &obj::Obj];

/// A kind of file that holds one frame.
pub trait Format: fmt::Debug + Sync {
    /// What names of its files end in, in lower case and without the dot.
    fn extension(&self) -> &'static str;

    /// What it cannot hold of what is asked for; called before any work.
    ///
    /// # Errors
    /// In words, which begin with the option that asks for it.
    fn check(&self, model: &Model, output: &Output) -> Result<(), String>;

    /// The bytes of a frame's file.
    ///
    /// # Errors
    /// [`Error::Encode`].
    fn encode(&self, frame: &Frame<'_>) -> Result<Encoded, Error>;

    /// Reads the bytes as a reader of the format does, so that no file gets its name that others refuse. `path` is for
    /// messages.
    ///
    /// # Errors
    /// [`Error::Encode`].
    fn read_back(&self, pieces: &[Vec<u8>], path: &Path) -> Result<(), Error>;

    /// What makes one file of those of several frames, which then holds them by time; `None` where a file holds one frame.
    fn join(&self) -> Option<Join> {
        None
    }
}

/// Joins files of frames. No more than a value of one frame is in memory.
pub type Join = fn(&Joining<'_>, &mut dyn Write) -> Result<(), Error>;

/// Frames on their way into one file.
pub struct Joining<'a> {
    /// The scene.
    pub model: &'a Model,
    /// What is asked for.
    pub output: &'a Output,
    /// The file that it becomes.
    pub path: &'a Path,
    /// The frames' files, rising.
    pub frames: &'a [(i64, PathBuf)],
    /// Ends it between two values.
    pub interrupt: &'a Interrupt,
}

/// The bytes of a frame's file.
#[derive(Debug)]
pub struct Encoded {
    /// In pieces.
    pub pieces: Vec<Vec<u8>>,
    /// Of polygons that were merged: how many.
    pub polygons: Option<PolygonRecord>,
}

/// A frame on its way into a file.
pub struct Frame<'a> {
    /// The scene.
    pub prepared: &'a Prepared,
    /// The frame's number.
    pub number: i64,
    /// Its grids.
    pub computed: &'a Computed,
    /// What is asked for.
    pub output: &'a Output,
}

/// The format of files with such a name.
pub fn format_of(path: &Path) -> Option<&'static dyn Format> {
    let extension = path.extension()?;
    FORMATS.into_iter().find(|format| extension.eq_ignore_ascii_case(format.extension()))
}

/// Reads a frame pattern whose name ends as one of the formats asks for.
///
/// # Errors
/// Those of [`FramePattern::new`].
pub fn pattern(path: &Path) -> Result<FramePattern, PatternError> {
    FramePattern::new(path, &FORMATS.map(Format::extension))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::bake::{
        Bytes, Existing, Identity, Known, Sampling, Sequence, State, bake, compute_frame, judge_all, verify,
    };
    use crate::node::{Source, load};
    use crate::shot::PrepareOptions;
    use crate::text::Overrides;
    use crate::vdb::Compression;

    /// Each format holds a frame of a scene, notices what is cut off, and its files are known as done and as whole.
    #[test]
    fn every_format_writes_and_knows_its_frames() {
        let model = Arc::new(load(&Source::Builtin("heart".into()), &Overrides::default()).unwrap());
        let options = PrepareOptions {
            voxel_size: None,
            resolution: Some(16),
            half_width: None,
            memory_limit: None,
            cache: None,
            cancel: Arc::default(),
            progress: &|_, _| {},
        };
        let prepared = model.prepare(&options).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let interrupt = Interrupt::default();
        for (row, format) in FORMATS.into_iter().enumerate() {
            let extension = format.extension();
            assert!(extension.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit()), "{extension}");
            assert!(FORMATS[..row].iter().all(|other| other.extension() != extension), "{extension} stands twice");
            let sequence = Sequence { pattern: pattern(&folder.path().join(format!("m.####.{extension}"))).unwrap() };
            assert_eq!(format_of(&sequence.pattern.file(1)).map(Format::extension), Some(extension));
            let sampling = Sampling::Resolution(16);
            let output = Output {
                identity: Identity::new(String::new(), sampling, 3.0, Vec::new(), Compression::default()),
                sequence,
                format,
                compression: Compression::default(),
                existing: Existing::Refuse,
                allow_empty: false,
                max_memory: Bytes(u64::MAX),
            };
            format.check(&model, &output).unwrap();

            let computed = compute_frame(&prepared, 1, 1, Bytes(u64::MAX), &interrupt, &|_| {}).unwrap();
            let frame = Frame { prepared: &prepared, number: 1, computed: &computed, output: &output };
            let mut pieces = format.encode(&frame).unwrap().pieces;
            let path = Path::new("a frame");
            format.read_back(&pieces, path).unwrap();
            pieces.last_mut().unwrap().pop();
            assert!(format.read_back(&pieces, path).is_err(), "{extension} is read though its end is missing");

            let baked = bake(&prepared, &[1], &output, &interrupt, &|_| {});
            assert!(baked.written.len() == 1 && baked.failed.is_empty() && baked.stopped.is_none(), "{baked:?}");
            let known = Known::read(&output.sequence).unwrap();
            let states = judge_all(&output.sequence, &[1], &known, &output.identity, &interrupt).unwrap();
            assert!(matches!(states[..], [(1, State::Done(_))]), "{states:?}");
            let verdict = verify(&output.sequence, &interrupt).unwrap().unwrap();
            assert!(verdict.findings.is_empty() && verdict.bytes == baked.written[0].bytes, "{verdict:?}");
        }
    }
}
