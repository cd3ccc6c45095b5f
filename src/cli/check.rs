//! `hfvdb check`: is the scene right, and what would it take? Is the file sound?

use std::fmt::Write;
use std::path::Path;

use clap::Args;
use serde_json::json;

use super::failure::Failure;
use super::job;
use super::options::{Global, Sampling, SceneArguments, SceneChanges};
use super::progress::Progress;
use crate::bake;
use crate::scene::{self, Model, MorphReport, Origin};
use crate::vdb::{self, Client, Lint, Severity};

/// Arguments of `hfvdb check`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  hfvdb check cubism                              a scene: errors with their line, voxels, memory
  hfvdb check cubism -v                           each value, and whether the scene gave it
  hfvdb check any.0001.vdb                        a file: what all programs would show wrong
  hfvdb check any.0001.vdb --for blender,houdini  and what these two ask for

Errors, which programs show wrong or not at all, make exit code 1; warnings do not: they may be as
you want it. Each says what to do.")]
pub struct Arguments {
    /// A scene file (.toml or .json), the name of a built-in scene, or a .vdb file of any maker
    #[arg(value_name = "SCENE or FILE.vdb")]
    input: String,

    /// Programs that a .vdb file has to serve: blender, houdini, unreal, usd
    #[arg(long = "for", value_name = "PROGRAMS", value_delimiter = ',')]
    clients: Vec<Client>,

    #[command(flatten)]
    changes: SceneChanges,
    #[command(flatten)]
    sampling: Sampling,
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let path = Path::new(&arguments.input);
    if path.extension().is_some_and(|end| end.eq_ignore_ascii_case("vdb")) {
        return of_file(path, &arguments.clients, global);
    }
    if !arguments.clients.is_empty() {
        return Err(Failure::usage("--for is about .vdb files; bake the scene, and check what came out"));
    }
    of_scene(arguments, global)
}

/// What is wrong with a file of any maker.
fn of_file(path: &Path, clients: &[Client], global: &Global) -> Result<(), Failure> {
    let Lint { grids, findings } = vdb::lint(path, clients)?;
    let errors = findings.iter().filter(|finding| finding.severity == Severity::Error).count();
    let warnings = findings.len() - errors;
    for finding in &findings {
        match finding.severity {
            Severity::Error => super::say(&format!("error: {}: {finding}", path.display())),
            Severity::Warning => global.warn(&format!("{}: {finding}", path.display())),
        }
    }
    if global.json {
        super::print_json(&json!({ "path": path, "grids": grids, "findings": findings }))?;
    } else {
        let names = if grids.is_empty() { "none".into() } else { grids.join(", ") };
        super::print(&format!("{}: grids {names}; {errors} errors, {warnings} warnings\n", path.display()))?;
    }
    if errors > 0 {
        return Err(Failure::work(format!("{} is not sound", path.display())).with_results());
    }
    Ok(())
}

/// Whether a scene is right, and what it would take.
fn of_scene(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let scene = SceneArguments { scene: arguments.input.clone(), changes: arguments.changes.clone() };
    let model = job::load(&scene, global)?;
    let interrupt = job::interrupt()?;
    let progress = Progress::new(1, global);
    let prepared = job::prepare(&model, &arguments.sampling, None, &interrupt, &progress, global)?;
    let shot = model.shot.range;
    let count = shot.last - shot.first + 1;
    // A shot's middle is where a morph is largest, its ends are where shapes are most intricate.
    let mut frames = vec![shot.first, shot.first + (shot.last - shot.first) / 2, shot.last];
    frames.dedup();
    frames.retain(|frame| prepared.is_made_alone(*frame));
    let mut largest: Option<bake::Estimate> = None;
    for frame in frames {
        let estimate = bake::estimate(&prepared, &prepared.frame(frame)?, bake::in_flight(count as usize));
        if largest.is_none_or(|largest| estimate.memory > largest.memory) {
            largest = Some(estimate);
        }
    }
    // Measured only where it is asked for: it takes about as long as a preview.
    let numbers: Vec<(i64, MorphReport)> = if global.verbose {
        let of_frame = |frame| Ok(prepared.report(frame)?.map(|report| (frame, report)));
        (shot.first..=shot.last).map(of_frame).filter_map(Result::transpose).collect::<Result<_, scene::Error>>()?
    } else {
        Vec::new()
    };
    drop(progress);
    let voxel_size = prepared.lattice.voxel_size.get();
    let limit = job::limit(&arguments.sampling);
    let Some(estimate) = largest else { return Ok(()) };
    if global.json {
        let mut document = json!({
            "scene": scene.scene,
            "frames": [shot.first, shot.last],
            "voxel_size": voxel_size,
            "box": [prepared.extent.min.to_array(), prepared.extent.max.to_array()],
            "unit": model.unit,
            "estimate": {
                "active_voxels": estimate.voxels,
                "blocks": estimate.blocks,
                "memory_bytes": estimate.memory.0,
                "file_bytes": estimate.file.0,
            },
            "memory_limit_bytes": limit.0,
        });
        if !numbers.is_empty() {
            document["morph"] =
                numbers.iter().map(|(frame, report)| json!({ "frame": frame, "report": report })).collect();
        }
        super::print_json(&document)?;
    } else {
        let mut text = if global.verbose { settings(&model) } else { String::new() };
        let size = prepared.extent.size();
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "frames {}-{} ({count})\nbox {:.4} x {:.4} x {:.4} {}\nvoxel size {voxel_size}\n\
             about {:.2e} voxels, {} of memory (limit {limit}), at most {} a file before compression\n",
            shot.first, shot.last, size.x, size.y, size.z, model.unit, estimate.voxels, estimate.memory, estimate.file
        );
        text.push_str(&table(&numbers, model.shot.fps));
        super::print(&text)?;
    }
    if estimate.memory > limit {
        let error = bake::Error::Memory { needed: estimate.memory, limit, voxels: estimate.voxels };
        return Err(Failure::from(error).with_results());
    }
    Ok(())
}

/// A morph's numbers, a line for each frame. Volumes in cubic units, speed in units a second.
fn table(numbers: &[(i64, MorphReport)], fps: f64) -> String {
    if numbers.is_empty() {
        return String::new();
    }
    let mut text = format!(
        "{:>8} {:>7} {:>12} {:>12} {:>12} {:>6} {:>12}\n",
        "frame", "t", "volume to be", "volume", "change", "pieces", "top speed"
    );
    for (frame, report) in numbers {
        let target = report.numbers.target.map_or_else(|| "-".into(), |target| format!("{target:.5}"));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{frame:>8} {:>7.4} {target:>12} {:>12.5} {:>12.5} {:>6} {:>12.4}",
            report.numbers.t,
            report.numbers.volume,
            report.numbers.change,
            report.numbers.pieces,
            report.displacement * fps
        );
    }
    text
}

/// Every value and who gave it.
fn settings(model: &Model) -> String {
    let lines = model.settings.iter().map(|setting| {
        let origin = match setting.origin {
            Origin::Default => "default",
            _ => "scene",
        };
        format!("{:40} {:24} {origin}\n", setting.name, setting.value)
    });
    lines.collect()
}
