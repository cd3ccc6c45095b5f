//! One frame of a scene: computed, with what there is to say about it, and written.

use std::time::{Duration, Instant};

use super::asked::{Attributes, ComputeError, Interior};
use super::compute::{Computed, Distances, Ranges, compute};
use super::estimate::check_memory;
use super::output::Encoded;
use super::record::{Beyond, PolygonRecord, Record, RecordFile};
use super::sealed::{self, hexadecimal};
use super::{Bytes, Error, Interrupt, Output, Velocities, inside, output};
use crate::disk;
use crate::distance::band::{self, Dropped, Settings, Thin};
use crate::grid::Band;
use crate::shot;
use crate::shot::Prepared;

/// Computes one frame of a scene, in a job that has so many in flight and no more memory than the limit.
pub fn compute_frame(
    prepared: &Prepared,
    frame: i64,
    in_flight: usize,
    limit: Bytes,
    interrupt: &Interrupt,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Computed, Error> {
    let content = prepared.frame(frame).map_err(of_scene)?;
    check_memory(prepared, &content, in_flight, limit)?;
    let settings = Settings {
        lattice: prepared.lattice,
        half_width: prepared.half_width,
        region: content.region,
        feet: prepared.feet,
        cancel: interrupt.flag(),
        progress,
    };
    let model = prepared.model();
    let output = &model.output;
    let name = output.colour_name.as_str();
    let attributes = Attributes {
        colour: content.colour.as_deref().map(|colour| (name, colour)),
        scalars: &content.scalars,
        movement: content.movement.as_ref(),
        interior: output.fills_inside().then_some(Interior { density: output.density, limit }),
    };
    let of_grid = |grid: &str, error: ComputeError| {
        let problem = format!("frame {frame}: {error}");
        prepared.attribute_problem(grid, &problem).map_or(Error::Frame(frame, error), Error::Scene)
    };
    let distances = Distances { choice: model.written_distance(), step: model.written_step(), limit };
    compute(&*content.field, attributes, &settings, content.keep, distances).map_err(|error| match error {
        ComputeError::Distance(band::Error::Cancelled) => Error::Interrupted,
        // What measuring was stopped for is no number.
        _ if interrupt.is_raised() => Error::Interrupted,
        ComputeError::Memory { needed, voxels } => {
            Error::Memory { needed: Bytes(needed), limit, voxels: voxels as f64 }
        }
        ComputeError::Density { .. } => of_grid(inside::DENSITY, error),
        ComputeError::Colour { .. } => of_grid(name, error),
        ComputeError::Scalar { name: ref grid, .. } => of_grid(&grid.clone(), error),
        ComputeError::Method(ref problem) => {
            Error::Scene(prepared.distance_problem(format!("frame {frame}: {problem}")))
        }
        error => Error::Frame(frame, error),
    })
}

fn of_scene(error: shot::Error) -> Error {
    match error {
        shot::Error::Cancelled => Error::Interrupted,
        error => Error::Scene(error),
    }
}

/// A frame without a surface.
pub fn empty(prepared: &Prepared) -> Computed {
    let band = Band {
        lattice: prepared.lattice,
        half_width: prepared.half_width,
        origins: Vec::new(),
        distances: Vec::new(),
        active: Vec::new(),
        inside_tiles: Vec::new(),
    };
    let report = band::Report::default();
    let ranges = Ranges::none();
    Computed {
        band,
        colour: None,
        scalars: Vec::new(),
        velocities: None,
        insides: None,
        report,
        bright_voxels: 0,
        ranges,
    }
}

/// One voxel in so many that are too fast is worth a warning: a few are wherever pieces meet or vanish.
const NOTED: u64 = 1000;

/// What is thinner than this share of a voxel is no wall, but where faces meet at next to no angle.
const RUNS_OUT: f64 = 1e-3;

/// Pieces that are left out and that are crumbs have less of the volume.
const NOTED_SHARE: f64 = 0.02;

/// What the measurement noticed, in words.
pub(super) fn warnings(computed: &Computed) -> Vec<String> {
    let mut warnings = Vec::new();
    let report = &computed.report;
    let sides = ["-x", "+x", "-y", "+y", "-z", "+z"];
    let cut: Vec<_> =
        sides.iter().zip(report.cut_voxels).filter(|&(_, voxels)| voxels > 0).map(|(side, _)| *side).collect();
    if !cut.is_empty() {
        warnings.push(format!("the shape is cut by its bounds at {}; widen `bounds`", cut.join(", ")));
    }
    if let Some(Thin { at, .. }) = report.thin.first() {
        let sizes = report.thin.iter().map(|thin| thin.size).filter(|&size| size > 0.0);
        let thinnest = sizes.fold(f64::INFINITY, f64::min);
        let enough = if thinnest == f64::INFINITY {
            "they need smaller voxels to hold".into()
        } else if thinnest < RUNS_OUT * computed.band.lattice.voxel_size.get() {
            "some run out to nothing, and no voxels hold these".into()
        } else {
            format!("they need voxels of {} to hold", rounded(thinnest, OF_THIN))
        };
        warnings.push(format!(
            "features thinner than a voxel at {}, one near ({:.4}, {:.4}, {:.4}); {enough}",
            voxels(report.thin.iter().map(|thin| u64::from(thin.voxels)).sum()),
            at.x,
            at.y,
            at.z
        ));
    }
    let Dropped { pieces, share } = report.dropped;
    if share >= NOTED_SHARE {
        let pieces = if pieces == 1 { "1 piece".into() } else { format!("{pieces} pieces") };
        let percent = 100.0 * share;
        warnings.push(format!("`keep` or `min_piece` leaves out {pieces}, {percent:.0} % of the volume"));
    }
    if computed.bright_voxels > 0 {
        warnings.push(format!("colours above 1 at {}; they are kept", voxels(computed.bright_voxels)));
    }
    if let Some(Velocities { held_voxels, max_speed, max_change, .. }) = &computed.velocities
        && held_voxels * NOTED >= computed.band.active_voxels().max(1)
    {
        let own = if max_change < max_speed {
            format!(", {max_speed:.6} with the objects' own motion,")
        } else {
            String::new()
        };
        warnings.push(format!(
            "faster than {max_change:.6} units a second{own} at {}, and held to that (`output.max_speed`)",
            voxels(*held_voxels)
        ));
    }
    warnings
}

/// A number to so many digits, at least one.
pub fn rounded(number: f64, digits: usize) -> f64 {
    format!("{number:.*e}", digits - 1).parse().unwrap_or(number)
}

/// The digits that are known of how thin a feature is, and more.
pub(super) const OF_THIN: usize = 2;

/// So many voxels, in words.
fn voxels(count: u64) -> String {
    if count == 1 { "1 voxel".into() } else { format!("{count} voxels") }
}

/// A frame's file on its way to its name.
pub(super) struct Staged {
    file: disk::Staged,
    record: Record,
    start: Instant,
}

impl Staged {
    pub fn frame(&self) -> i64 {
        self.record.frame
    }

    /// What writing it noticed, in words.
    pub fn warning(&self, output: &Output) -> Option<String> {
        let Some(PolygonRecord { beyond: Some(Beyond { triangles, near: [x, y, z] }), .. }) = self.record.polygons
        else {
            return None;
        };
        let which = if triangles == 1 { "1 triangle" } else { &format!("{triangles} triangles") };
        Some(format!(
            "{which} may be further than {} voxels from the surface, as without --adaptivity: notches and slivers at sharp \
             edges, one near ({x:.4}, {y:.4}, {z:.4}); take smaller voxels",
            output.identity.adaptivity
        ))
    }
}

/// Writes one frame, except for syncing and renaming it.
pub(super) fn stage_frame(
    prepared: &Prepared,
    frame: i64,
    computed: &Computed,
    output: &Output,
    compute: Duration,
) -> Result<Staged, Error> {
    let start = Instant::now();
    let report = prepared.report(frame).map_err(of_scene)?;
    let Output { sequence, format, existing, .. } = output;
    let path = sequence.pattern.file(frame);
    disk::check_target(&path, existing.replaces())?;
    let Encoded { pieces, polygons } = format.encode(&output::Frame { prepared, number: frame, computed, output })?;
    let stage = || disk::stage(&path, &pieces, existing.replaces());
    let (file, sound) = rayon::join(stage, || format.read_back(&pieces, &path));
    let file = file?;
    sound?;
    let written = file.written();
    let content = (written.bytes, hexadecimal(&written.sha256));
    let record = Record::new(frame, sequence.file_name(frame), content, computed, report, polygons, compute);
    Ok(Staged { file, record, start })
}

/// Gives a frame's file its name, and writes its record once it stands.
pub(super) fn commit_frame(staged: Staged, output: &Output) -> Result<Record, Error> {
    let Staged { file, mut record, start } = staged;
    file.commit()?;
    record.write_seconds = start.elapsed().as_secs_f64();
    let sequence = &output.sequence;
    let frame = record.frame;
    let record =
        RecordFile { hfvdb_record: 1, pattern: sequence.pattern.text(), identity: output.identity.clone(), record };
    sealed::write(&sequence.record(frame), &record)?;
    Ok(record.record)
}
