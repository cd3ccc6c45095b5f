//! From arguments to a scene made ready: what `bake`, `morph`, `check` and `preview` have in common.

use std::sync::Arc;

use super::failure::Failure;
use super::options::{Global, Sampling, SceneArguments};
use super::progress::{PREPARING, Progress};
use super::{events, signals};
use crate::bake::{Bytes, Frames, Interrupt, default_limit};
use crate::node;
use crate::node::{Model, Source};
use crate::shot;
use crate::shot::{PrepareOptions, Prepared};
use crate::terminal;
use crate::text;
use crate::text::Overrides;

/// Starts to listen for signals.
pub fn interrupt() -> Result<Interrupt, Failure> {
    signals::listen(events::interrupted).map_err(|error| Failure::work(format!("cannot listen for signals: {error}")))
}

/// Reads a scene and says what is worth saying about it.
pub fn load(arguments: &SceneArguments, global: &Global) -> Result<Arc<Model>, Failure> {
    let overrides = Overrides { set: arguments.changes.set.clone(), variant: arguments.changes.variant.clone() };
    let model = node::load(&Source::of_argument(&arguments.scene), &overrides)?;
    warn(&model.warnings, global);
    Ok(Arc::new(model))
}

/// Prints a scene's warnings.
pub fn warn(warnings: &text::Diagnostics, global: &Global) {
    if warnings.is_empty() {
        return;
    }
    if events::on() {
        global.warn(warnings.render(false).trim_end());
    } else if !global.quiet {
        super::say_as_is(&terminal::coloured(warnings.render(terminal::styled()).trim_end()));
    }
}

/// Makes a scene ready for frames.
pub fn prepare(
    model: &Arc<Model>,
    sampling: &Sampling,
    default_resolution: Option<u32>,
    interrupt: &Interrupt,
    progress: &Progress,
    global: &Global,
) -> Result<Prepared, Failure> {
    progress.stage(PREPARING);
    let told = |share: f64, what: &str| progress.of_preparing(share, what);
    let options = PrepareOptions { progress: &told, ..options(sampling, default_resolution, interrupt) };
    let prepared = model.prepare(&options).map_err(|error| not_ready(error, model, interrupt))?;
    if let Some(problem) = options.cache.as_ref().and_then(|cache| cache.problem()) {
        global.warn(&problem);
    }
    warn(&prepared.warnings, global);
    Ok(prepared)
}

/// Makes a scene ready for estimates.
pub fn outlook(
    model: &Arc<Model>,
    sampling: &Sampling,
    interrupt: &Interrupt,
    global: &Global,
) -> Result<Prepared, Failure> {
    let prepared = model.outlook(&options(sampling, None, interrupt));
    let prepared = prepared.map_err(|error| not_ready(error, model, interrupt))?;
    warn(&prepared.warnings, global);
    Ok(prepared)
}

/// Whether a scene can be made ready, as far as that is known before anything is measured.
pub fn examine(model: &Arc<Model>, sampling: &Sampling, interrupt: &Interrupt, global: &Global) -> Result<(), Failure> {
    let warnings = model.examine(&options(sampling, None, interrupt));
    warn(&warnings.map_err(|error| not_ready(error, model, interrupt))?, global);
    Ok(())
}

fn options(sampling: &Sampling, default_resolution: Option<u32>, interrupt: &Interrupt) -> PrepareOptions<'static> {
    PrepareOptions {
        voxel_size: sampling.voxel_size,
        resolution: sampling.resolution.or(default_resolution),
        half_width: sampling.half_width,
        memory_limit: usize::try_from(limit(sampling).0).ok(),
        cache: sampling.caching.open().map(Arc::new),
        cancel: Arc::clone(interrupt.flag()),
        progress: &|_, _| (),
    }
}

fn not_ready(error: shot::Error, model: &Model, interrupt: &Interrupt) -> Failure {
    let takes_too_much = matches!(error, shot::Error::Memory { .. });
    let failure = failure_of(error, interrupt);
    if takes_too_much { failure.about(&model.name) } else { failure }
}

/// A failure, or the interruption that caused it.
pub fn failure_of(error: impl Into<Failure>, interrupt: &Interrupt) -> Failure {
    if interrupt.is_raised() { signals::interrupted() } else { error.into() }
}

/// The memory the job may take.
pub fn limit(sampling: &Sampling) -> Bytes {
    sampling.max_memory.unwrap_or_else(default_limit)
}

/// The frames asked for, else the whole shot; a note where some lie outside of it, an error where some lack a file.
pub fn frames(asked: Option<&Frames>, model: &Model, global: &Global) -> Result<Frames, Failure> {
    files_of(asked.map(Frames::numbers), model)?;
    for lacking in model.lacking(None).list() {
        global.warn(&format!(
            "{}; none of the frames asked for shows them. The box, and the voxel size where a resolution gives it, is that of \
             the other files: once all are there it is another scene, to be baked anew",
            lacking.message
        ));
    }
    let shot = model.shot;
    let frames = match asked {
        Some(frames) => frames.clone(),
        None => Frames::of_range(shot.range).map_err(|error| Failure::work(error.to_string()))?,
    };
    let (first, last) = frames.ends();
    if first < shot.range.first || last > shot.range.last {
        let range = (shot.range.first, shot.range.last);
        if shot.still {
            global.warn("the scene has no `frames` and does not move: all frames are alike");
        } else {
            global.warn(&format!("some frames lie outside of the shot {}-{}, where its ends hold", range.0, range.1));
        }
    }
    Ok(frames)
}

/// Refuses frames, or a shot, of which some lack a file.
pub fn files_of(frames: Option<&[i64]>, model: &Model) -> Result<(), Failure> {
    let lacking = model.lacking(frames);
    if lacking.is_empty() { Ok(()) } else { Err(shot::Error::Scene(lacking).into()) }
}

/// The scene's hash in hexadecimal.
pub fn hash(model: &Model) -> Result<String, Failure> {
    let bytes = model
        .hash()
        .map_err(|(file, error)| Failure::work(format!("{}: cannot read this file: {error}", file.name())))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
