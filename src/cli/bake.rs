//! `hfvdb bake`: frames of a scene into files.

use std::sync::Arc;
use std::time::Instant;

use clap::Args;
use serde_json::json;

use super::failure::Failure;
use super::job;
use super::options::{Compression, Global, Sampling, SceneArguments, Writing};
use super::progress::Progress;
use crate::bake::{self, Bytes, Event, FramePattern, Output, Record};
use crate::scene::Model;
use crate::vdb;

/// Arguments of `hfvdb bake`.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    writing: Writing,
    #[command(flatten)]
    sampling: Sampling,
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let pattern = FramePattern::new(&arguments.writing.output, "vdb")?;
    let model = job::load(&arguments.scene, global)?;
    write_frames(&model, pattern, &arguments.writing, &arguments.sampling, global)
}

/// Bakes the frames asked for.
pub fn write_frames(
    model: &Arc<Model>,
    pattern: FramePattern,
    writing: &Writing,
    sampling: &Sampling,
    global: &Global,
) -> Result<(), Failure> {
    let frames = job::frames(writing.frames.as_ref(), model, global)?;
    let frames = frames.numbers();
    pattern.holds(frames.len())?;
    if !pattern.number_is_last() && !global.quiet {
        eprintln!("warning: the frame's number should stand last before .vdb: Blender reads the last digits there");
    }
    let interrupt = job::interrupt()?;
    let output = output(model, pattern, writing, sampling)?;
    let _folder = bake::make_ready(&output.pattern, frames, output.overwrite)
        .map_err(|error| Failure::work(error.to_string()))?;

    let start = Instant::now();
    let progress = Progress::new(frames.len(), global);
    let prepared = job::prepare(model, sampling, None, &interrupt, &progress, global)?;
    if global.verbose {
        let size = prepared.extent.size();
        progress.say(&format!(
            "voxel size {}, box {:.4} x {:.4} x {:.4} {}, measured in {:.2?}",
            prepared.lattice.voxel_size.get(),
            size.x,
            size.y,
            size.z,
            model.unit,
            start.elapsed()
        ));
    }
    let events = |event: Event<'_>| match event {
        Event::Progress(place, share) => {
            progress.stage(&format!("frame {} ({} of {})", frames[place], place + 1, frames.len()));
            progress.at(place, share);
        }
        Event::Warning(text) => progress.say(&format!("warning: {text}")),
        Event::Written(record) => {
            if global.verbose {
                progress.say(&in_words(record));
            }
        }
    };
    let records = bake::bake(&prepared, frames, &output, &interrupt, &events)
        .map_err(|error| job::failure_of(error, &interrupt))?;
    drop(progress);
    report(&records, &prepared, start, global)
}

fn output(model: &Model, pattern: FramePattern, writing: &Writing, sampling: &Sampling) -> Result<Output, Failure> {
    let compression = match (writing.compression, model.output.compression) {
        (Some(Compression::Blosc), _) | (None, "blosc") => vdb::Compression::Blosc,
        (Some(Compression::Zip), _) | (None, "zip") => vdb::Compression::Zip,
        (Some(Compression::None), _) | (None, _) => vdb::Compression::None,
    };
    let known = ["surface", model.output.colour_name.as_str()];
    if let Some(wrong) = writing.half.iter().find(|name| !known.contains(&name.as_str())) {
        return Err(Failure::usage(format!("--half: no grid \"{wrong}\" is written; there are {}", known.join(", "))));
    }
    let scene_half = model.output.half.iter().map(|&name| name.to_owned());
    let half = if writing.half.is_empty() { scene_half.collect() } else { writing.half.clone() };
    Ok(Output {
        pattern,
        half,
        compression,
        overwrite: writing.overwrite,
        allow_empty: writing.allow_empty,
        max_memory: job::limit(sampling),
        scene_hash: job::hash(model)?,
    })
}

fn in_words(record: &Record) -> String {
    format!(
        "frame {}: {} voxels in {} blocks, volume {:.6}, computed in {:.2?}, written in {:.2?}, {}",
        record.frame,
        record.voxels,
        record.blocks,
        record.volume,
        record.compute,
        record.write,
        Bytes(record.bytes)
    )
}

/// The results: paths, or a document.
fn report(
    records: &[Record],
    prepared: &crate::scene::Prepared,
    start: Instant,
    global: &Global,
) -> Result<(), Failure> {
    let seconds = start.elapsed().as_secs_f64();
    if !global.quiet {
        let bytes = Bytes(records.iter().map(|record| record.bytes).sum());
        let frames = if records.len() == 1 { "1 frame".into() } else { format!("{} frames", records.len()) };
        eprintln!("{frames}, {bytes}, in {seconds:.1} s");
    }
    if !global.json {
        let paths: String = records.iter().map(|record| format!("{}\n", record.path.display())).collect();
        return super::print(&paths);
    }
    let frames: Vec<_> = records
        .iter()
        .map(|record| {
            json!({
                "frame": record.frame,
                "path": record.path,
                "bytes": record.bytes,
                "active_voxels": record.voxels,
                "blocks": record.blocks,
                "volume": record.volume,
                "compute_seconds": record.compute.as_secs_f64(),
                "write_seconds": record.write.as_secs_f64(),
            })
        })
        .collect();
    super::print_json(&json!({
        "voxel_size": prepared.lattice.voxel_size.get(),
        "seconds": seconds,
        "frames": frames,
    }))
}
