//! Options that several subcommands share.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde_json::json;

use super::caching::Caching;
use super::{events, paths};
use crate::bake::{Bytes, Existing, Frames};
use crate::text::key::GREATEST;

/// Options of every subcommand.
#[derive(Args, Clone, Debug)]
pub struct Global {
    /// Number of threads; the result does not depend on it [default: all cores]
    #[arg(long, value_name = "N", global = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,

    /// Print one JSON document on stdout instead of text
    #[arg(long, global = true)]
    pub json: bool,

    /// Say nothing on stderr but errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,

    /// Say more on stderr
    #[arg(short, long, global = true)]
    pub verbose: bool,

    /// How progress is told on stderr
    #[arg(long, value_enum, value_name = "KIND", global = true, default_value_t = ProgressKind::Bar, hide_default_value = true)]
    pub progress: ProgressKind,
}

impl Global {
    /// Warns on stderr, unless nothing shall be said.
    pub fn warn(&self, text: &str) {
        if !events::tell("warning", &json!({ "message": text })) && !self.quiet {
            super::say(&format!("warning: {text}"));
        }
    }
}

/// How progress is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProgressKind {
    /// A bar with the time left, on a terminal only (the default)
    Bar,
    /// One JSON object a line, for farms: docs/output.md has the events
    Json,
}

/// Which scene, and what to change in it.
#[derive(Args, Clone, Debug)]
pub struct SceneArguments {
    /// A scene file (.toml or .json), or the name of a built-in scene (see `hfvdb scenes`)
    #[arg(value_name = "SCENE", value_parser = paths::text())]
    pub scene: String,

    #[command(flatten)]
    pub changes: SceneChanges,
}

/// Changes of a scene from the command line.
#[derive(Args, Clone, Debug)]
pub struct SceneChanges {
    /// Give one of the scene's [param] names another value; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub set: Vec<String>,

    /// Use one of the scene's [variant.NAME] tables
    #[arg(long, value_name = "NAME")]
    pub variant: Option<String>,
}

/// How finely the scene is sampled.
#[derive(Args, Clone, Debug)]
pub struct Sampling {
    /// Voxels along the longest side of the object over the whole shot [default: the scene's, else 256]
    #[arg(long, value_name = "N", conflicts_with = "voxel_size", value_parser = clap::value_parser!(u32).range(1..=1_000_000_000))]
    pub resolution: Option<u32>,

    /// Edge of a voxel, in the scene's unit, instead of a resolution
    #[arg(long, value_name = "LENGTH", value_parser = positive, allow_negative_numbers = true)]
    pub voxel_size: Option<f64>,

    /// Half the width of the narrow band, in voxels, on each side of the surface [default: the scene's, else 3]
    #[arg(long, value_name = "VOXELS", value_parser = half_width, allow_negative_numbers = true)]
    pub half_width: Option<f64>,

    /// Memory the job may take, such as 8G; a job that needs more is refused with exit code 3
    /// [default: 80 % of the least of free memory and what cgroups, ulimit -v and ulimit -d leave]
    #[arg(long, value_name = "BYTES")]
    pub max_memory: Option<Bytes>,

    #[command(flatten)]
    pub caching: Caching,
}

/// Where the files go and what they hold.
#[derive(Args, Clone, Debug)]
pub struct Writing {
    /// File to write; several frames need a frame token in the name: m.####.vdb, m.%04d.vdb or 'm.$F4.vdb'; .glb, .usda, .ply and .obj hold polygons, and m.usda all frames
    #[arg(short, long, value_name = "FILE", value_parser = paths::path())]
    pub output: PathBuf,

    /// Frames to bake: 7, 1-48, 1-48x4, or lists with commas; picks from the scene's shot and never stretches it
    /// [default: the whole shot]
    #[arg(long, value_name = "FRAMES", allow_hyphen_values = true)]
    pub frames: Option<Frames>,

    /// Grids to keep in 16-bit floats, such as Cd
    #[arg(long, value_name = "GRIDS", value_delimiter = ',')]
    pub half: Vec<String>,

    /// How voxels are compressed in the file [default: the scene's, else blosc]
    #[arg(long, value_enum)]
    pub compression: Option<Compression>,

    /// Of polygons: merge triangles where surface, colours and attributes stay the same within so many voxels, from 0 (merge
    /// none) to 1; 0.1 leaves about a tenth of a smooth object's
    #[arg(long, value_name = "VOXELS", value_parser = adaptivity, allow_negative_numbers = true, default_value_t = 0.0)]
    pub adaptivity: f64,

    /// Replace files that exist
    #[arg(long, conflicts_with = "resume")]
    pub overwrite: bool,

    /// Keep frames that are done, judged by their content (scene, options, SHA-256), and bake all others
    #[arg(long)]
    pub resume: bool,

    /// Write nothing; say which files would be written, and estimate voxels, memory, time and bytes from one frame
    #[arg(long)]
    pub dry_run: bool,

    /// Write a valid empty file where a frame has no surface, instead of failing
    #[arg(long)]
    pub allow_empty: bool,
}

impl Writing {
    /// What to do with files that exist.
    pub fn existing(&self) -> Existing {
        match (self.overwrite, self.resume) {
            (true, _) => Existing::Overwrite,
            (_, true) => Existing::Resume,
            _ => Existing::Refuse,
        }
    }
}

/// Compression of voxels in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Compression {
    /// Fast, the field's default
    Blosc,
    /// Slower, for readers without Blosc
    Zip,
    /// None at all
    None,
}

fn number(text: &str) -> Result<f64, String> {
    text.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(|| "this is no finite number".into())
}

/// A voxel size as typed: finite and positive.
pub fn positive(text: &str) -> Result<f64, String> {
    number(text).and_then(|value| match value {
        _ if value <= 0.0 => Err("it must be greater than 0; try --resolution 256".into()),
        _ if value > GREATEST => {
            Err(format!("it must be at most {GREATEST:e}, as lengths in scenes; try --resolution 256"))
        }
        _ => Ok(value),
    })
}

fn adaptivity(text: &str) -> Result<f64, String> {
    number(text).and_then(|value| match value {
        value if value < 0.0 => Err("it must not be negative; try --adaptivity 0.1".into()),
        value if value > 1.0 => {
            Err(format!("an error of {value} voxels is that of larger voxels; the most is 1, usual is 0.1"))
        }
        value => Ok(value),
    })
}

fn half_width(text: &str) -> Result<f64, String> {
    number(text).and_then(|value| match value {
        value if value < 1.5 => Err(format!(
            "a half width of {value} voxels is too thin to mesh and to sample colours from: \
             it needs at least 1.5; try --half-width 3"
        )),
        value if value > 100.0 => {
            Err(format!("a half width of {value} voxels is no narrow band; the most is 100, usual is 3"))
        }
        value => Ok(value),
    })
}
