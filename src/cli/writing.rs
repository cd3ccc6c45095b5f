//! Frames into files: what `bake` and `morph` have in common.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use serde_json::json;

use super::failure::Failure;
use super::options::{Compression, Global, Sampling, Writing};
use super::progress::Progress;
use super::report::{Outcome, report};
use super::{dry_run, events, job, signals};
use crate::bake::output::{FORMATS, Format, format_of};
use crate::bake::{
    self, Baked, Bytes, Claim, Event, FramePattern, Frames, Identity, Interrupt, Output, Record, Sequence, Source,
    State, Whole, Wish, judge_all,
};
use crate::node::Model;
use crate::vdb;

/// The most failed frames that are told of one by one.
const MOST_FAILURES: usize = 5;

/// What is asked for.
pub struct Request<'a> {
    /// The scene.
    pub model: Arc<Model>,
    /// Where it came from.
    pub source: Source,
    /// Where the frames go.
    pub pattern: FramePattern,
    pub writing: &'a Writing,
    pub sampling: &'a Sampling,
}

/// Bakes the frames asked for.
pub fn write_frames(request: &Request<'_>, global: &Global) -> Result<(), Failure> {
    let Request { model, pattern, writing, sampling, .. } = request;
    let frames = job::frames(writing.frames.as_ref(), model, global)?;
    let joins = !pattern.has_token() && frames.numbers().len() > 1 && format(pattern).join().is_some();
    if !joins {
        pattern.holds(frames.numbers().len())?;
    }
    if !pattern.number_is_last() {
        global.warn("the frame's number should stand last before .vdb: Blender reads the last digits there");
    }
    let interrupt = job::interrupt()?;
    let mut output = output(request)?;
    let whole = if joins { Some(Whole::new(pattern.clone())?) } else { None };
    if let Some(whole) = &whole {
        output.sequence = whole.frames.clone();
    }
    let wish = Wish {
        identity: output.identity.clone(),
        source: request.source.clone(),
        frames: frames.clone(),
        existing: output.existing,
    };
    if writing.dry_run {
        return dry_run::run(model, sampling, &output, whole.as_ref(), &wish, &interrupt, global);
    }
    let start = Instant::now();
    let _outer = whole.as_ref().map(|whole| bake::make_ready(&whole.sequence)).transpose()?;
    let mut lock = None;
    if let Some(whole) = &whole {
        lock = Some(whole.lock()?);
        if let Some(record) = whole.examine(&wish, &interrupt).map_err(|error| job::failure_of(error, &interrupt))? {
            let sequence = &whole.sequence;
            let (kept, baked, seconds) = (record.frames, Baked::default(), start.elapsed());
            let outcome = Outcome { scene: &model.name, sequence, asked: &frames, kept, baked, seconds };
            return report(outcome, Ok(()), &interrupt, global);
        }
    }
    let _folder = bake::make_ready(&output.sequence)?;
    let claim = Claim::take(&output.sequence, &wish, &interrupt).map_err(|error| job::failure_of(error, &interrupt))?;
    for warning in &claim.warnings {
        global.warn(warning);
    }
    let (kept, to_do) = to_do(&claim, &output, &frames, &interrupt, global)?;
    let progress = Progress::new(to_do.len(), global);
    events::tell("start", &start_event(&output, &frames, &to_do));
    let mut baked = Baked::default();
    if let Some(frames) = Frames::of_numbers(to_do) {
        let prepared = job::prepare(model, sampling, None, &interrupt, &progress, global)?;
        if global.verbose {
            let size = prepared.extent.size();
            let text = format!(
                "voxel size {}, box {:.4} x {:.4} x {:.4} {}, measured in {:.2?}",
                prepared.lattice.voxel_size.get(),
                size.x,
                size.y,
                size.z,
                model.unit,
                start.elapsed()
            );
            progress.tell("message", &json!({ "message": text }), &text);
        }
        let frames = frames.numbers();
        let failures = AtomicUsize::new(0);
        let on_event = |event: Event<'_>| {
            // Of one frame alone the end tells, and of many it lists the rest.
            let is_failure = matches!(event, Event::Failed(..));
            let shown = frames.len() > 1 && (!is_failure || failures.fetch_add(1, Ordering::Relaxed) < MOST_FAILURES);
            on_event(&event, shown, frames.len(), &progress, &output.sequence, global);
        };
        baked = bake::bake(&prepared, frames, &output, &interrupt, &on_event);
    }
    drop(progress);
    let finished = claim.finish();
    let mut sequence = &output.sequence;
    if let (Some(whole), Some(lock)) = (&whole, lock) {
        let mut records: Vec<Record> = [&kept, &baked.kept, &baked.written].into_iter().flatten().cloned().collect();
        records.sort_by_key(|record| record.frame);
        if records.len() == wish.frames.numbers().len() && finished.is_ok() {
            match whole.join(model, &output, &wish, &records, lock, &interrupt) {
                Ok(()) => sequence = &whole.sequence,
                Err(error) => baked.stopped = Some(error),
            }
        }
    }
    let outcome = Outcome { scene: &model.name, sequence, asked: &frames, kept, baked, seconds: start.elapsed() };
    report(outcome, finished, &interrupt, global)
}

/// The frames that are done, and those that are to be baked.
fn to_do(
    claim: &Claim,
    output: &Output,
    frames: &Frames,
    interrupt: &Interrupt,
    global: &Global,
) -> Result<(Vec<Record>, Vec<i64>), Failure> {
    if output.existing != bake::Existing::Resume {
        return Ok((Vec::new(), frames.numbers().to_vec()));
    }
    let states = judge_all(&output.sequence, frames.numbers(), &claim.known, &output.identity, interrupt)
        .ok_or_else(signals::interrupted)?;
    let (mut kept, mut to_do, mut why) = (Vec::new(), Vec::new(), Vec::<(String, Vec<i64>)>::new());
    for (frame, state) in states {
        let reason = match state {
            State::Done(record) => {
                kept.push(*record);
                continue;
            }
            State::Several(held) => {
                return Err(bake::Refusal::OtherFrames(output.sequence.pattern.file(frame), held).into());
            }
            State::Missing => "missing".into(),
            State::Unknown => "of unknown making".into(),
            State::Other(how) => format!("baked otherwise ({how})"),
            State::Changed(how) => format!("changed ({how})"),
        };
        to_do.push(frame);
        match why.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, frames)) => frames.push(frame),
            None => why.push((reason, vec![frame])),
        }
    }
    let mut text = format!("resume: {} of {} frames are done", kept.len(), frames.numbers().len());
    let shown = why.len().min(8);
    for (reason, frames) in &why[..shown] {
        text += &format!(
            "; {reason}: {}",
            Frames::of_numbers(frames.iter().copied()).map_or_else(String::new, |f| f.to_string())
        );
    }
    if why.len() > shown {
        text += &format!("; and {} more reasons", why.len() - shown);
    }
    if !events::tell("message", &json!({ "message": text })) && !global.quiet {
        super::say(&text);
    }
    Ok((kept, to_do))
}

fn start_event(output: &Output, frames: &Frames, to_do: &[i64]) -> serde_json::Value {
    json!({
        "sequence": output.sequence.display(),
        "identity": output.identity,
        "frames": frames.to_string(),
        "to_do": to_do.len(),
        "kept": frames.numbers().len() - to_do.len(),
    })
}

fn on_event(event: &Event<'_>, shown: bool, count: usize, progress: &Progress, sequence: &Sequence, global: &Global) {
    match event {
        Event::Started { place, frame } => {
            progress.stage(&format!("frame {frame} ({} of {count})", place + 1));
            progress.at(*place, 0.0);
            events::tell("frame-started", &json!({ "frame": frame, "place": place + 1, "of": count }));
        }
        Event::Progress { place, frame, share } => progress.of_frame(*frame, *place, *share),
        Event::Warning(frame, text) => progress.tell(
            "warning",
            &json!({ "frame": frame, "message": text }),
            &format!("warning: frame {frame}: {text}"),
        ),
        Event::Written(record) => {
            let path = sequence.pattern.file(record.frame);
            if !events::tell("frame-written", &json!({ "path": path, "record": record })) && global.verbose {
                progress.say(&in_words(record));
            }
        }
        Event::Kept(record) => progress.tell(
            "frame-kept",
            &json!({ "frame": record.frame }),
            &format!("frame {}: another process has baked it meanwhile", record.frame),
        ),
        Event::Failed(frame, error) => {
            let message = error.to_string();
            if !events::tell("frame-failed", &json!({ "frame": frame, "message": message })) && shown {
                let line: String = message.lines().next().unwrap_or_default().chars().take(300).collect();
                let line = line.strip_prefix("error: ").unwrap_or(&line);
                let which = if line.contains("frame") { String::new() } else { format!("frame {frame}: ") };
                progress.print(&format!("failed: {which}{line}"));
            }
        }
    }
}

fn format(pattern: &FramePattern) -> &'static dyn Format {
    format_of(&pattern.file(0)).unwrap_or(FORMATS[0])
}

fn output(request: &Request<'_>) -> Result<Output, Failure> {
    let Request { model, writing, sampling, .. } = request;
    let compression = match (writing.compression, model.output.compression) {
        (Some(Compression::Blosc), _) | (None, "blosc") => vdb::Compression::Blosc,
        (Some(Compression::Zip), _) | (None, "zip") => vdb::Compression::Zip,
        (Some(Compression::None), _) | (None, _) => vdb::Compression::None,
    };
    let known: Vec<&str> = model.grid_names().into_iter().filter(|name| model.output.writes(name)).collect();
    if let Some(wrong) = writing.half.iter().find(|name| !known.contains(&name.as_str())) {
        return Err(Failure::usage(format!("--half: no grid \"{wrong}\" is written; there are {}", known.join(", "))));
    }
    let half = if writing.half.is_empty() { model.output.half.clone() } else { writing.half.clone() };
    let finely = match (sampling.voxel_size, sampling.resolution, model.output.voxel_size) {
        (Some(edge), _, _) | (None, None, Some(edge)) => bake::Sampling::VoxelSize(edge),
        (None, Some(resolution), _) => bake::Sampling::Resolution(resolution),
        (None, None, None) => bake::Sampling::Resolution(model.output.resolution),
    };
    let half_width = sampling.half_width.unwrap_or(model.output.half_width);
    let output = Output {
        sequence: Sequence { pattern: request.pattern.clone() },
        format: format(&request.pattern),
        identity: Identity {
            adaptivity: writing.adaptivity,
            ..Identity::new(job::hash(model)?, finely, half_width, half, compression)
        },
        compression,
        existing: writing.existing(),
        allow_empty: writing.allow_empty,
        max_memory: job::limit(sampling),
    };
    output.format.check(model, &output).map_err(Failure::usage)?;
    Ok(output)
}

fn in_words(record: &Record) -> String {
    format!(
        "frame {}: {} voxels in {} blocks, volume {:.6}, computed in {:.2} s, written in {:.2} s, {}",
        record.frame,
        record.active_voxels,
        record.blocks,
        record.volume,
        record.compute_seconds,
        record.write_seconds,
        Bytes(record.bytes)
    )
}
