//! `--dry-run`: what a bake would write and take; writes nothing.

use std::fmt::Write;
use std::sync::Arc;
use std::time::Instant;

use serde_json::json;

use super::failure::Failure;
use super::options::{Global, Sampling};
use super::progress::Progress;
use super::{job, signals};
use crate::bake::{self, Bytes, Existing, Interrupt, Known, Output, Probe, State, Whole, Wish, judge_all, refusal};
use crate::disk::free_bytes;
use crate::node::Model;

/// Says what would be written.
pub fn run(
    model: &Arc<Model>,
    sampling: &Sampling,
    output: &Output,
    whole: Option<&Whole>,
    wish: &Wish,
    interrupt: &Interrupt,
    global: &Global,
) -> Result<(), Failure> {
    let sequence = &output.sequence;
    let shown = whole.map_or(sequence, |whole| &whole.sequence);
    bake::check_place(shown)?;
    let is_done = match whole {
        Some(whole) => whole.examine(wish, interrupt)?.is_some(),
        None => false,
    };
    let known = Known::for_bake(sequence, output.existing)?;
    if let Some(refusal) = refusal(sequence, &known, wish, false) {
        return Err(refusal.into());
    }
    let states = judge_all(sequence, wish.frames.numbers(), &known, &output.identity, interrupt)
        .ok_or_else(signals::interrupted)?;
    let fate = |state: &State| match whole {
        Some(_) if is_done => "kept",
        Some(whole) if whole.path().exists() => "replaced",
        _ => fate(state, output.existing),
    };
    let plan: Vec<(i64, &str)> = states.iter().map(|(frame, state)| (*frame, fate(state))).collect();
    let to_do: Vec<i64> = plan.iter().filter(|(_, fate)| *fate != "kept").map(|(frame, _)| *frame).collect();

    let start = Instant::now();
    let progress = Progress::new(1, global);
    let prepared = job::prepare(model, sampling, None, interrupt, &progress, global)?;
    let prepare_seconds = start.elapsed().as_secs_f64();
    let voxel_size = prepared.lattice.voxel_size.get();
    let frame = *to_do.get(to_do.len() / 2).unwrap_or(&wish.frames.numbers()[wish.frames.numbers().len() / 2]);
    let estimate = bake::estimate(&prepared, &prepared.frame(frame)?, bake::in_flight(to_do.len()));
    let coarser = Probe::scale(&estimate, output.max_memory);
    let prepared = if coarser > 1.0 {
        let sampling = Sampling { voxel_size: Some(voxel_size * coarser), resolution: None, ..sampling.clone() };
        job::prepare(model, &sampling, None, interrupt, &progress, global)?
    } else {
        prepared
    };
    let probe = bake::probe(&prepared, frame, coarser, output, interrupt, &|share| progress.at(0, share))
        .map_err(|error| job::failure_of(error, interrupt))?;
    drop(progress);

    let count = to_do.len() as f64;
    let seconds = if to_do.is_empty() { 0.0 } else { prepare_seconds + count * probe.frame_seconds() };
    let total = Bytes((count * probe.file.0 as f64) as u64);
    let free = free_bytes(shown.folder()).map(Bytes);
    if global.json {
        let path = |frame: i64| shown.pattern.file(frame);
        let frames: Vec<_> =
            plan.iter().map(|(frame, fate)| json!({ "frame": frame, "path": path(*frame), "fate": fate })).collect();
        super::print_json(&json!({
            "dry_run": true,
            "sequence": shown.display(),
            "manifest": shown.manifest(),
            "identity": output.identity,
            "voxel_size": voxel_size,
            "frames": frames,
            "probe": { "frame": frame, "voxel_size": probe.voxel_size, "coarser": coarser },
            "estimate": {
                "frames_to_bake": to_do.len(),
                "active_voxels": probe.active_voxels,
                "memory_bytes": estimate.memory.0,
                "file_bytes": probe.file.0,
                "total_bytes": total.0,
                "frame_seconds": probe.frame_seconds(),
                "seconds": prepared.is_made_alone(frame).then_some(seconds),
            },
            "memory_limit_bytes": output.max_memory.0,
            "free_disk_bytes": free.map(|free| free.0),
        }))?;
    } else {
        let mut text = String::new();
        let mut lines: Vec<String> =
            plan.iter().map(|(frame, fate)| format!("{} {fate}\n", shown.pattern.file(*frame).display())).collect();
        // A file may hold several frames.
        lines.dedup();
        text += &lines.concat();
        let how = if coarser > 1.0 {
            format!("frame {frame} with voxels {coarser:.2} times as large, scaled up")
        } else {
            format!("frame {frame}, baked in memory")
        };
        let room = free.map(|free| format!(" ({free} free on the disk)")).unwrap_or_default();
        let beside = if prepared.is_made_alone(frame) {
            ""
        } else {
            " and that of OpenVDB's own morph, which makes each frame from the one before and may take many times as long"
        };
        let _ = writeln!(
            text,
            "{} frames to bake, {} to keep\nfrom {how}: {:.2e} voxels a frame, {} of memory (limit {}), {} a file\n\
             in all about {}{room} and {seconds:.0} s on this machine, without the disk's time{beside}",
            to_do.len(),
            plan.len() - to_do.len(),
            probe.active_voxels,
            estimate.memory,
            output.max_memory,
            probe.file,
            total,
        );
        super::print(&text)?;
    }
    // Frames that become one file are there twice while it is made.
    let needed = Bytes(if whole.is_some() { 2 * total.0 } else { total.0 });
    if let Some(free) = free.filter(|free| needed > *free) {
        let folder = shown.folder().display();
        global.warn(&format!(
            "all frames need about {needed}, and {free} are free in {folder}: make room, bake to another disk, or use \
             larger voxels or --half Cd"
        ));
    }
    if estimate.memory > output.max_memory {
        let error = bake::Error::Memory { needed: estimate.memory, limit: output.max_memory, voxels: estimate.voxels };
        return Err(Failure::from(error).with_results());
    }
    Ok(())
}

/// What would become of a file.
fn fate(state: &State, existing: Existing) -> &'static str {
    match state {
        State::Missing => "new",
        State::Done(_) if existing == Existing::Resume => "kept",
        _ => "replaced",
    }
}
