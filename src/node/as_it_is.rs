//! The scene of files as they stand, for command lines without one: a mesh or voxels, or such files by frame.

use std::path::{Path, PathBuf};

use crate::node::compose::{Part, Scene, path};
use crate::node::import::vdb::chosen;
use crate::node::keys::{GRIDS, UNITS};
use crate::node::model::Model;
use crate::text::diagnostic::Diagnostics;
use crate::text::overrides::Overrides;
use crate::text::pattern::FramePattern;
use crate::vdb::{Opened, StoredClass, VELOCITIES, metadata_text};

/// Files as they stand.
#[derive(Debug)]
pub struct Files {
    /// The file, or the pattern of files by frame.
    path: PathBuf,
    /// The frames that there are.
    frames: Vec<i64>,
    /// One of them.
    first: PathBuf,
}

/// What a file of voxels has beside its surface.
#[derive(Debug, Default)]
pub struct Beside {
    /// A voxel's edge, world units.
    pub edge: f64,
    /// Grids of numbers that can be taken along as attributes.
    pub attributes: Vec<String>,
    /// Grids that cannot, for their names or their voxels.
    pub left_out: Vec<String>,
    /// Other volumes: level sets and a density.
    pub volumes: Vec<String>,
    /// Whether it says how it moves.
    pub has_velocity: bool,
    /// The unit of length that it says.
    pub unit: Option<&'static str>,
    /// The axis that points up, as it says.
    pub up: Option<&'static str>,
}

impl Files {
    /// A path of the command line: a file, or a frame pattern where there is no file of that very name.
    ///
    /// # Errors
    /// In words: a pattern that is none, or of no file.
    pub fn new(path: &Path) -> Result<Self, String> {
        let alone = |first: &Path| Self { path: first.into(), frames: Vec::new(), first: first.into() };
        if path.exists() {
            return Ok(alone(path));
        }
        let pattern = FramePattern::new(path, &[]).map_err(|error| error.to_string())?;
        if !pattern.has_token() {
            return Ok(alone(path));
        }
        let path = pattern.folder().join(pattern.text());
        let frames = pattern.numbers().map_err(|error| format!("{}: {error}", path.display()))?;
        let first = frames.first().ok_or_else(|| format!("{}: there is no frame with such a name", path.display()))?;
        Ok(Self { first: pattern.file(*first), path, frames })
    }

    /// Those from the first to the last of some frames.
    pub fn between(mut self, ends: (i64, i64)) -> Self {
        self.frames.retain(|frame| (ends.0..=ends.1).contains(frame));
        self
    }

    /// Their name, as people write it.
    pub fn name(&self) -> String {
        self.path.display().to_string()
    }

    /// One of them that is a frame of a pattern, by whatever path.
    pub fn which_is_written(&self, pattern: &FramePattern) -> Option<PathBuf> {
        let own = FramePattern::new(&self.path, &[]).ok().filter(FramePattern::has_token);
        let file = |frame: i64| own.as_ref().map_or_else(|| self.path.clone(), |own| own.file(frame));
        let frames = if self.frames.is_empty() { &[0][..] } else { &self.frames };
        let is_same = |frame: &i64| {
            let [read, written] = [file(*frame), pattern.file(*frame)].map(|path| path.canonicalize().ok());
            read.is_some() && read == written
        };
        frames.iter().find(|frame| is_same(frame)).map(|frame| file(*frame))
    }

    /// Whether they are voxels, by their name.
    pub fn are_voxels(&self) -> bool {
        self.path.extension().is_some_and(|end| end.eq_ignore_ascii_case("vdb"))
    }

    /// What voxels have beside the surface that is in a grid of this name, or in the one that is most likely meant.
    ///
    /// # Errors
    /// In words.
    pub fn look(&self, grid: Option<&str>) -> Result<Beside, String> {
        let opened = Opened::open(&self.first).map_err(|error| error.to_string())?;
        let layout = &opened.layout;
        let surface =
            chosen(&opened, grid).map_err(|(problem, help)| format!("{}: {problem}; {help}", self.first.display()))?;
        let mut beside = Beside {
            edge: surface.transform.voxel_size().map_or(0.0, |size| size.element_product().cbrt()),
            has_velocity: layout.grids.iter().any(|grid| VELOCITIES.contains(&grid.name.as_str())),
            ..Beside::default()
        };
        let text = |name: &str| metadata_text(&layout.metadata, name);
        beside.unit = text("hfvdb_unit").and_then(|unit| UNITS.iter().find(|known| **known == unit)).copied();
        beside.up = text("hfvdb_up").and_then(|up| ["y", "z"].into_iter().find(|known| *known == up));
        let numbers = layout.grids.iter().filter(|grid| ["float", "double"].contains(&grid.value_type()));
        for grid in numbers.filter(|grid| grid.name != surface.name) {
            let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
            if grid.name == "density" || StoredClass::of(&grid.metadata) == StoredClass::LevelSet {
                beside.volumes.push(grid.name.clone());
                continue;
            }
            let taken = grid.name.chars().all(is_name)
                && grid.name.starts_with(|first: char| !first.is_ascii_digit())
                && !GRIDS.contains(&grid.name.as_str())
                && grid.transform.uniform_voxel_size().is_some();
            if taken { &mut beside.attributes } else { &mut beside.left_out }.push(grid.name.clone());
        }
        Ok(beside)
    }

    /// Their scene, of `[shape.file]`.
    ///
    /// # Errors
    /// Those of [`crate::node::load`].
    pub fn scene(&self, attributes: &[String], overrides: &Overrides) -> Result<Model, Diagnostics> {
        let kind = if self.are_voxels() { "vdb" } else { "mesh" };
        let named = || Part::new(kind, path(&self.path));
        let mut shape = named();
        if let [first, more @ ..] = attributes {
            let table = more.iter().fold(Part::new(first, named()), |table, name| table.with(name, named()));
            shape = shape.with("attribute", table);
        }
        let mut scene = Scene::new();
        if let [first, .., last] | [first @ last] = self.frames[..] {
            scene = scene.with("frames", format!("{first}-{last}"));
        }
        scene.shape("file", shape).model_with("the command line", Path::new(""), overrides)
    }
}
