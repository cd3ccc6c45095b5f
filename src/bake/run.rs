//! The bake: frame after frame, the next one computed while the last one is written.

use std::fmt;
use std::path::PathBuf;
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use super::compute::{ComputeError, Computed, compute};
use super::{Bytes, FramePattern, Interrupt};
use crate::distance::band::{self, Settings};
use crate::distance::descent::Scope;
use crate::distance::extent;
use crate::grid::{Band, measure};
use crate::scene::{self, FrameContent, Prepared};
use crate::vdb;

/// What to write and how.
#[derive(Clone, Debug)]
pub struct Output {
    /// One file a frame.
    pub pattern: FramePattern,
    /// Grids kept in 16-bit floats.
    pub half: Vec<String>,
    /// Compression of the voxels.
    pub compression: vdb::Compression,
    /// Replace files that exist.
    pub overwrite: bool,
    /// Write empty frames instead of failing.
    pub allow_empty: bool,
    /// The most memory that the job may take.
    pub max_memory: Bytes,
    /// The scene's hash, for the files' metadata.
    pub scene_hash: String,
}

/// A frame that was written.
#[derive(Clone, Debug)]
pub struct Record {
    /// Its number.
    pub frame: i64,
    /// Its file.
    pub path: PathBuf,
    /// Size of the file in bytes.
    pub bytes: u64,
    /// Active voxels of the level set.
    pub voxels: u64,
    /// Leaf blocks.
    pub blocks: u64,
    /// Volume inside, cubic world units.
    pub volume: f64,
    /// Time to compute it.
    pub compute: Duration,
    /// Time to hand it over, encode, check and sync it.
    pub write: Duration,
}

/// What happens while baking.
pub enum Event<'a> {
    /// A share (0 to 1) of the frame with this place among the frames is done.
    Progress(usize, f64),
    /// Something to tell the user.
    Warning(String),
    /// A frame is on the disk.
    Written(&'a Record),
}

/// Why a bake ended early.
#[derive(Debug)]
pub enum Error {
    /// The scene gives no such frame.
    Scene(scene::Error),
    /// A frame could not be computed.
    Frame(i64, ComputeError),
    /// A file could not be written.
    Write(vdb::Error),
    /// More memory would be needed than allowed.
    Memory {
        /// About what is needed.
        needed: Bytes,
        /// What is allowed.
        limit: Bytes,
        /// About how many active voxels.
        voxels: f64,
    },
    /// A signal came.
    Interrupted,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scene(error) => error.fmt(f),
            Self::Frame(frame, ComputeError::Distance(error @ band::Error::Empty { .. })) => {
                write!(f, "frame {frame} is empty: {error}; --allow-empty writes a valid empty file")
            }
            Self::Frame(frame, error) => write!(f, "frame {frame}: {error}"),
            Self::Write(error) => error.fmt(f),
            Self::Memory { needed, limit, voxels } => write!(
                f,
                "about {voxels:.2e} voxels would take about {needed} of memory, and the limit is {limit}; \
                 take a larger voxel size or a smaller --resolution, or raise the limit with --max-memory"
            ),
            Self::Interrupted => f.write_str("interrupted"),
        }
    }
}

impl std::error::Error for Error {}

/// What a frame will take, estimated before anything is allocated.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// Active voxels.
    pub voxels: f64,
    /// Leaf blocks.
    pub blocks: f64,
    /// Memory at the job's peak, two frames in flight.
    pub memory: Bytes,
    /// Size of the file without compression.
    pub file: Bytes,
}

/// What the program takes whatever it bakes: itself, OpenVDB, stacks, a chunk of blocks in flight.
const BASE_BYTES: f64 = 120e6;

/// Estimates one frame.
pub fn estimate(prepared: &Prepared, content: &FrameContent) -> Estimate {
    let scope = Scope { lattice: prepared.lattice, half_width: prepared.half_width, region: content.region };
    let found = extent::estimate(&*content.field, &scope);
    let coloured = content.colour.is_some();
    let memory = BASE_BYTES + prepared.memory_estimate() as f64 + found.memory(coloured);
    let bytes = |value: f64| Bytes(value.min(u64::MAX as f64) as u64);
    Estimate { voxels: found.voxels, blocks: found.blocks, memory: bytes(memory), file: bytes(found.file(coloured)) }
}

/// Refuses frames whose estimate is over the limit.
pub fn check_memory(prepared: &Prepared, content: &FrameContent, limit: Bytes) -> Result<Estimate, Error> {
    let estimate = estimate(prepared, content);
    if estimate.memory > limit {
        return Err(Error::Memory { needed: estimate.memory, limit, voxels: estimate.voxels });
    }
    Ok(estimate)
}

/// Computes one frame of a scene.
pub fn compute_frame(
    prepared: &Prepared,
    frame: i64,
    limit: Bytes,
    interrupt: &Interrupt,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Computed, Error> {
    let content = prepared.frame(frame).map_err(|error| match error {
        scene::Error::Cancelled => Error::Interrupted,
        error => Error::Scene(error),
    })?;
    check_memory(prepared, &content, limit)?;
    let settings = Settings {
        lattice: prepared.lattice,
        half_width: prepared.half_width,
        region: content.region,
        cancel: interrupt.flag(),
        progress,
    };
    let name = prepared.model().output.colour_name.as_str();
    let colour = content.colour.as_deref().map(|colour| (colour, name));
    compute(&*content.field, colour, &settings, content.keep).map_err(|error| match error {
        ComputeError::Distance(band::Error::Cancelled) => Error::Interrupted,
        ComputeError::Colour { .. } => {
            let problem = format!("frame {frame}: {error}");
            prepared.colour_problem(&problem).map_or(Error::Frame(frame, error), Error::Scene)
        }
        error => Error::Frame(frame, error),
    })
}

/// Bakes frames into files, in order.
///
/// Stops at the first frame that fails; the files written until then are whole and stay.
pub fn bake(
    prepared: &Prepared,
    frames: &[i64],
    output: &Output,
    interrupt: &Interrupt,
    events: &(dyn Fn(Event<'_>) + Sync),
) -> Result<Vec<Record>, Error> {
    // A rendezvous: one frame is computed while one is written, never more.
    let (send, receive) = mpsc::sync_channel::<(i64, Computed, Duration)>(0);
    thread::scope(|scope| {
        let writer = scope.spawn(move || {
            let mut records = Vec::with_capacity(frames.len());
            for (frame, computed, duration) in receive {
                let record = write_frame(prepared, frame, &computed, output, duration)?;
                events(Event::Written(&record));
                records.push(record);
            }
            Ok(records)
        });
        let computed = compute_all(prepared, frames, output, interrupt, events, &send);
        drop(send);
        let written = writer.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        // A failed write is why the computing stopped, if both failed.
        let records = written?;
        computed.map(|()| records)
    })
}

/// Computes the frames and hands them to the writer until one fails or the writer is gone.
fn compute_all(
    prepared: &Prepared,
    frames: &[i64],
    output: &Output,
    interrupt: &Interrupt,
    events: &(dyn Fn(Event<'_>) + Sync),
    send: &mpsc::SyncSender<(i64, Computed, Duration)>,
) -> Result<(), Error> {
    for (place, &frame) in frames.iter().enumerate() {
        let start = Instant::now();
        let progress = |share: f64| events(Event::Progress(place, share));
        let computed = match compute_frame(prepared, frame, output.max_memory, interrupt, &progress) {
            Err(Error::Frame(_, ComputeError::Distance(band::Error::Empty { solid: false }))) if output.allow_empty => {
                events(Event::Warning(format!("frame {frame} is empty")));
                empty(prepared)
            }
            computed => computed?,
        };
        for warning in warnings(frame, &computed) {
            events(Event::Warning(warning));
        }
        if interrupt.is_raised() {
            return Err(Error::Interrupted);
        }
        if send.send((frame, computed, start.elapsed())).is_err() {
            break;
        }
    }
    Ok(())
}

/// A frame without a surface.
fn empty(prepared: &Prepared) -> Computed {
    let band = Band {
        lattice: prepared.lattice,
        half_width: prepared.half_width,
        origins: Vec::new(),
        distances: Vec::new(),
        active: Vec::new(),
        inside_tiles: Vec::new(),
    };
    Computed { band, colour: None, report: band::Report::default(), bright_voxels: 0 }
}

/// What the measurement noticed, in words.
fn warnings(frame: i64, computed: &Computed) -> Vec<String> {
    let mut warnings = Vec::new();
    let report = &computed.report;
    let sides = ["-x", "+x", "-y", "+y", "-z", "+z"];
    let cut: Vec<_> =
        sides.iter().zip(report.cut_voxels).filter(|&(_, voxels)| voxels > 0).map(|(side, _)| *side).collect();
    if !cut.is_empty() {
        warnings.push(format!("frame {frame}: the shape is cut by its bounds at {}; widen `bounds`", cut.join(", ")));
    }
    if let Some(at) = report.thin_at {
        warnings.push(format!(
            "frame {frame}: features thinner than a voxel at {} voxels, one near ({:.4}, {:.4}, {:.4}); \
             they need smaller voxels to hold",
            report.thin_voxels, at.x, at.y, at.z
        ));
    }
    if computed.bright_voxels > 0 {
        warnings.push(format!("frame {frame}: {} voxels have a colour above 1; they are kept", computed.bright_voxels));
    }
    warnings
}

/// Writes one frame.
fn write_frame(
    prepared: &Prepared,
    frame: i64,
    computed: &Computed,
    output: &Output,
    compute: Duration,
) -> Result<Record, Error> {
    let start = Instant::now();
    let path = output.pattern.file(frame);
    let mut grids = vec![vdb::Grid::level_set("surface", &computed.band)];
    if let Some(colour) = &computed.colour {
        grids.push(vdb::Grid::colour(&computed.band, colour));
    }
    for grid in &mut grids {
        grid.half = output.half.iter().any(|name| name == grid.name);
    }
    let metadata = metadata(prepared, frame, output);
    let options = vdb::WriteOptions { compression: output.compression, overwrite: output.overwrite };
    let written = vdb::write(&path, &vdb::Frame { grids, metadata }, &options).map_err(Error::Write)?;
    Ok(Record {
        frame,
        path,
        bytes: written.bytes,
        voxels: computed.band.active_voxels(),
        blocks: computed.band.origins.len() as u64,
        volume: measure::volume(&computed.band),
        compute,
        write: start.elapsed(),
    })
}

/// Metadata of a file: nothing that depends on time, host, threads, path or other frames.
fn metadata(prepared: &Prepared, frame: i64, output: &Output) -> vdb::Metadata {
    let model = prepared.model();
    let mut metadata = vdb::Metadata::new();
    metadata.insert("creator".into(), concat!("hfvdb ", env!("CARGO_PKG_VERSION")).into());
    metadata.insert("hfvdb_scene".into(), output.scene_hash.as_str().into());
    // Frame numbers beyond 32 bits are refused when a scene is read.
    metadata.insert("hfvdb_frame".into(), i32::try_from(frame).unwrap_or(i32::MAX).into());
    metadata.insert("hfvdb_fps".into(), model.shot.fps.into());
    metadata.insert("hfvdb_unit".into(), model.unit.into());
    metadata
}
