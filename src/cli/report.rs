//! What came of a bake: paths or a document on stdout, and the failure if there is one.

use std::time::Duration;

use serde_json::{Value, json};

use super::failure::Failure;
use super::options::Global;
use super::{events, job};
use crate::bake::{Baked, Bytes, Frames, Interrupt, Record, Refusal, Sequence};

/// What came of a bake.
pub struct Outcome<'a> {
    /// What messages call the scene.
    pub scene: &'a str,
    pub sequence: &'a Sequence,
    /// The frames asked for.
    pub asked: &'a Frames,
    /// Those that were done before.
    pub kept: Vec<Record>,
    pub baked: Baked,
    pub seconds: Duration,
}

/// Prints the results and gives the failure. `finished`: whether the manifest could be written.
pub fn report(
    outcome: Outcome<'_>,
    finished: Result<(), Refusal>,
    interrupt: &Interrupt,
    global: &Global,
) -> Result<(), Failure> {
    let Outcome { scene, sequence, asked, kept, baked, seconds } = outcome;
    let written = baked.written.len();
    let bytes = Bytes(baked.written.iter().map(|record| record.bytes).sum());
    let mut done: Vec<(Record, &str)> = baked.written.into_iter().map(|record| (record, "written")).collect();
    done.extend(kept.into_iter().chain(baked.kept).map(|record| (record, "kept")));
    done.sort_by_key(|(record, _)| record.frame);
    let failed: Vec<Value> =
        baked.failed.iter().map(|(frame, error)| json!({ "frame": frame, "message": error.to_string() })).collect();
    let of = Share { scene, done: done.len(), asked: asked.numbers().len() };
    let failure = failure(baked.failed, baked.stopped, finished, &of, interrupt);

    let seconds = seconds.as_secs_f64();
    if !global.quiet && !events::on() && !done.is_empty() {
        let frames = if written == 1 { "1 frame".into() } else { format!("{written} frames") };
        let kept = if done.len() > written { format!(", {} kept", done.len() - written) } else { String::new() };
        let polygons =
            done.iter().filter(|(_, state)| *state == "written").filter_map(|(record, _)| record.polygons.as_ref());
        let counts = polygons.map(|polygons| [polygons.unmerged, polygons.triangles]);
        let merged = match counts.reduce(|[a, b], [c, d]| [a + c, b + d]) {
            Some([before, after]) => format!(", {before} triangles merged into {after}"),
            None => String::new(),
        };
        super::say(&format!("{frames}, {bytes}, in {seconds:.1} s{kept}{merged}"));
    }
    let path = |record: &Record| sequence.pattern.file(record.frame);
    if global.json {
        let frames: Vec<_> = done.iter().map(|(record, state)| frame(record, &path(record), state)).collect();
        let mut document = json!({
            "sequence": sequence.display(),
            "manifest": sequence.manifest(),
            "voxel_size": done.first().map(|(record, _)| record.voxel_size),
            "seconds": seconds,
            "frames": frames,
            "failed": failed,
        });
        if let Some(failure) = &failure {
            document["error"] = json!({ "exit_code": failure.exit_code(), "message": failure.message() });
        }
        super::print_json(&document)?;
    } else {
        let mut paths: Vec<String> = done.iter().map(|(record, _)| format!("{}\n", path(record).display())).collect();
        // A file may hold several frames.
        paths.dedup();
        super::print(&paths.concat())?;
    }
    match failure {
        Some(failure) => Err(failure.with_results()),
        None => {
            events::tell("done", &json!({ "written": written, "kept": of.done - written, "bytes": bytes.0 }));
            Ok(())
        }
    }
}

fn frame(record: &Record, path: &std::path::Path, state: &str) -> Value {
    let mut document = json!({
        "frame": record.frame,
        "path": path,
        "state": state,
        "bytes": record.bytes,
        "sha256": record.sha256,
        "active_voxels": record.active_voxels,
        "blocks": record.blocks,
        "volume": record.volume,
        "compute_seconds": record.compute_seconds,
        "write_seconds": record.write_seconds,
    });
    if let Some(polygons) = &record.polygons {
        document["polygons"] = json!(polygons);
    }
    document
}

/// How many of the frames asked for are done.
struct Share<'a> {
    scene: &'a str,
    done: usize,
    asked: usize,
}

/// Why not all that was asked for is there.
fn failure(
    mut failed: Vec<(i64, crate::bake::Error)>,
    stopped: Option<crate::bake::Error>,
    finished: Result<(), Refusal>,
    of: &Share<'_>,
    interrupt: &Interrupt,
) -> Option<Failure> {
    let rest = match of.asked {
        1 => String::new(),
        asked => format!("; {} of {asked} frames are done, --resume goes on from there", of.done),
    };
    // What a scene gives no frame for is about the scene; what cannot be written names its file.
    let told = |error: crate::bake::Error| match error {
        error @ (crate::bake::Error::Frame(..)
        | crate::bake::Error::Hollow { .. }
        | crate::bake::Error::Memory { .. }) => Failure::from(error).about(of.scene),
        error => error.into(),
    };
    if let Some(error) = stopped {
        let failure = job::failure_of(told(error), interrupt);
        // An interruption tells by itself what stays.
        return Some(if interrupt.is_raised() { failure } else { failure.and(&rest) });
    }
    if failed.is_empty() {
        let not_listed = |error: Refusal| {
            Failure::work(format!("{error}; all frames and their records are whole: `hfvdb verify` makes the manifest"))
        };
        return finished.err().map(not_listed);
    }
    if of.asked == 1 {
        return failed.pop().map(|(_, error)| told(error));
    }
    let frames = Frames::of_numbers(failed.iter().map(|(frame, _)| *frame)).map_or_else(String::new, |f| f.to_string());
    let count = failed.len();
    // The first in full: a scene's errors show their place.
    let first = told(failed.swap_remove(0).1);
    let all = format!("\n{count} of {} frames failed: {frames}{rest}", of.asked);
    Some(first.and(&all))
}
