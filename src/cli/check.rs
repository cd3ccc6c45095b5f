//! `hfvdb check`: is the scene right, and what would it take? Is the file sound?

use std::fmt::Write;
use std::path::Path;

use clap::Args;
use serde_json::json;

use super::failure::Failure;
use super::options::{Global, Sampling, SceneArguments, SceneChanges};
use super::paths;
use super::progress::Progress;
use super::{check_mesh, files, job};
use crate::bake;
use crate::distance::method::ADF;
use crate::distance::octree::Report;
use crate::grid;
use crate::node::Model;
use crate::shot;
use crate::shot::MorphReport;
use crate::terminal;
use crate::text;
use crate::text::{FileSequence, Origin};
use crate::vdb::{self, Client, Finding, Lint, Severity};

/// Arguments of `hfvdb check`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  hfvdb check cubism                              a scene: errors with their line, voxels, memory
  hfvdb check cubism -v                           each value, and whether the scene gave it; a morph is measured,
                                                  and each of its frames told of; closed hollows of structures
                                                  are counted; of `adf` its tree is built
  hfvdb check cubism --no-estimate                errors alone
  hfvdb check any.0001.vdb                        a file: what all programs would show wrong
  hfvdb check any.0001.vdb --for blender,houdini  and what these two ask for
  hfvdb check out                                 all .vdb files of a folder, with one summary
  hfvdb check 'out/cubism.####.vdb'               all frames of a sequence
  hfvdb check fox.glb                             a mesh: size, holes, what crosses itself, its pictures

Errors, which programs show wrong or not at all, make exit code 1; warnings do not: they may be as
you want it. Each says what to do.")]
pub struct Arguments {
    /// A scene file (.toml or .json), the name of a built-in scene, meshes, or .vdb files of any maker: by name, by frame
    /// pattern, or all of a folder
    #[arg(value_name = "SCENE, FILE.vdb, MESH or FOLDER", required = true, value_parser = paths::text())]
    inputs: Vec<String>,

    /// Programs that a .vdb file has to serve: blender, houdini, karma, arnold, renderman, vray, redshift, moonray, unreal, usd
    #[arg(long = "for", value_name = "PROGRAMS", value_delimiter = ',')]
    clients: Vec<Client>,

    /// Only say whether a scene is right, without voxels, memory and size of files, of which -v tells more
    #[arg(long, conflicts_with = "verbose")]
    no_estimate: bool,

    #[command(flatten)]
    changes: SceneChanges,
    #[command(flatten)]
    sampling: Sampling,
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    files::none_is_nanovdb(&arguments.inputs)?;
    let is_files = |input: &String| {
        // A folder may have the name of a built-in scene: with a slash behind it is the folder.
        files::is_vdb(input) || (Path::new(input).is_dir() && !text::builtin_names().any(|name| name == input))
    };
    if arguments.inputs.iter().all(check_mesh::is_one) {
        return check_mesh::run(&arguments.inputs, global);
    }
    if arguments.inputs.iter().all(is_files) {
        let paths = files::of_all(&arguments.inputs)?;
        return match (paths.as_slice(), arguments.inputs.as_slice()) {
            ([path], [input]) if path == input => of_file(Path::new(path), &arguments.clients, global),
            _ => of_files(&paths, &arguments.clients, global),
        };
    }
    if arguments.inputs.len() > 1 {
        return Err(Failure::usage("check takes one scene, or any number of .vdb files and folders, or of meshes"));
    }
    if !arguments.clients.is_empty() {
        return Err(Failure::usage("--for is about .vdb files; bake the scene, and check what came out"));
    }
    of_scene(arguments, global)
}

/// Errors and warnings.
fn counted(findings: &[Finding]) -> [usize; 2] {
    [Severity::Error, Severity::Warning].map(|how| findings.iter().filter(|finding| finding.severity == how).count())
}

/// Says what is good to know.
fn note(text: &str, global: &Global) {
    if !global.quiet {
        super::say(&format!("note: {text}"));
    }
}

/// What is wrong with files of any maker: one after the other, what cannot be read among them, and all together.
fn of_files(paths: &[String], clients: &[Client], global: &Global) -> Result<(), Failure> {
    // The same of many files is said once.
    let mut said: Vec<(Finding, Vec<&str>)> = Vec::new();
    let (mut documents, mut unsound, mut all) = (Vec::new(), 0, [0; 2]);
    for path in paths {
        let Lint { grids, findings } = vdb::lint(path, clients).unwrap_or_else(|error| {
            let text = error.to_string();
            let problem = text.strip_prefix(&format!("{path}: ")).unwrap_or(&text).to_owned();
            let finding = Finding { severity: Severity::Error, client: None, grid: None, problem };
            Lint { grids: Vec::new(), findings: vec![finding] }
        });
        let [errors, warnings] = counted(&findings);
        all = [all[0] + errors, all[1] + warnings];
        unsound += usize::from(errors > 0);
        documents.push(json!({ "path": path, "grids": grids, "findings": findings }));
        for finding in findings {
            match said.iter_mut().find(|(other, _)| *other == finding) {
                Some((_, paths)) => paths.push(path),
                None => said.push((finding, vec![path])),
            }
        }
    }
    for (finding, paths) in &said {
        let more = if paths.len() > 1 { format!(" and {} more", paths.len() - 1) } else { String::new() };
        let text = format!("{}{more}: {finding}", paths[0]);
        match finding.severity {
            Severity::Error => super::say(&format!("error: {text}")),
            Severity::Warning => global.warn(&text),
            Severity::Note => note(&text, global),
        }
    }
    let [errors, warnings] = all;
    if global.json {
        super::print_json(&json!({ "files": documents, "errors": errors, "warnings": warnings, "unsound": unsound }))?;
    } else {
        super::print(&format!(
            "{} files: {} sound, {unsound} not; {errors} errors, {warnings} warnings\n",
            paths.len(),
            paths.len() - unsound
        ))?;
    }
    if unsound > 0 {
        return Err(Failure::work(format!("{unsound} of {} files are not sound", paths.len())).with_results());
    }
    Ok(())
}

/// What is wrong with a file of any maker.
fn of_file(path: &Path, clients: &[Client], global: &Global) -> Result<(), Failure> {
    let Lint { grids, findings } = vdb::lint(path, clients)?;
    let [errors, warnings] = counted(&findings);
    for finding in &findings {
        match finding.severity {
            Severity::Error => super::say(&format!("error: {}: {finding}", terminal::path(path))),
            Severity::Warning => global.warn(&format!("{}: {finding}", terminal::path(path))),
            Severity::Note => note(&format!("{}: {finding}", terminal::path(path)), global),
        }
    }
    if global.json {
        super::print_json(&json!({ "path": path, "grids": grids, "findings": findings }))?;
    } else {
        let names = if grids.is_empty() { "none".into() } else { terminal::one_line(&grids.join(", ")).into_owned() };
        super::print(&format!("{}: grids {names}; {errors} errors, {warnings} warnings\n", terminal::path(path)))?;
    }
    if errors > 0 {
        return Err(Failure::work(format!("{} is not sound", terminal::path(path))).with_results());
    }
    Ok(())
}

/// Whether a scene is right, and what it would take.
fn of_scene(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let scene = SceneArguments { scene: arguments.inputs[0].clone(), changes: arguments.changes.clone() };
    let model = job::load(&scene, global)?;
    job::files_of(None, &model)?;
    let interrupt = job::interrupt()?;
    let progress = Progress::new(1, global);
    progress.stage("looking at the scene");
    let shot = model.shot.range;
    let count = shot.last - shot.first + 1;
    if arguments.no_estimate {
        job::examine(&model, &arguments.sampling, &interrupt, global)?;
        drop(progress);
        if global.json {
            let document = json!({ "scene": scene.scene, "frames": [shot.first, shot.last], "unit": model.unit });
            return super::print_json(&document);
        }
        return super::print(&format!("frames {}-{} ({count})\n", shot.first, shot.last));
    }
    // A morph's own numbers need all of it; the rest can be told from a rough look.
    let prepared = if global.verbose {
        job::prepare(&model, &arguments.sampling, None, &interrupt, &progress, global)?
    } else {
        job::outlook(&model, &arguments.sampling, &interrupt, global)?
    };
    let about = if prepared.is_rough() { "about " } else { "" };
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
        (shot.first..=shot.last).map(of_frame).filter_map(Result::transpose).collect::<Result<_, shot::Error>>()?
    } else {
        Vec::new()
    };
    let limit = job::limit(&arguments.sampling);
    let Some(estimate) = largest else { return Ok(()) };
    // Of a frame that is made for it, so only where it is asked for, too.
    let hollows = if global.verbose && model.has_structures() && estimate.memory <= limit {
        progress.stage("counting hollows");
        let computed = bake::compute_frame(&prepared, shot.first, 1, limit, &interrupt, &|_| {})?;
        Some(grid::measure::hollows(computed.band))
    } else {
        None
    };
    // The tree of an adaptive distance is built to be told of.
    let mut trees: Vec<(&str, Report)> = Vec::new();
    if global.verbose && model.written_distance().method == ADF && estimate.memory <= limit {
        progress.stage("measuring distances");
        if let Some(shape) = prepared.in_plane(shot.first)? {
            let report = prepared.distance_in_plane(shot.first, &shape)?.report;
            trees.extend(report.map(|report| ("quadtree in the plane", report)));
        }
        let content = prepared.frame(shot.first)?;
        let report = prepared.distance(shot.first, &content.field, limit.0)?.report;
        trees.extend(report.map(|report| ("octree", report)));
    }
    drop(progress);
    let voxel_size = prepared.lattice.voxel_size.get();
    if global.json {
        let mut document = json!({
            "scene": scene.scene,
            "frames": [shot.first, shot.last],
            "voxel_size": voxel_size,
            "box": [prepared.extent.min.to_array(), prepared.extent.max.to_array()],
            "unit": model.unit,
            "set_operations": model.set_operations(),
            "exact": !prepared.is_rough(),
            "estimate": {
                "active_voxels": estimate.voxels,
                "blocks": estimate.blocks,
                "memory_bytes": estimate.memory.0,
                "file_bytes": estimate.file.0,
            },
            "memory_limit_bytes": limit.0,
        });
        if sequences(&model).next().is_some() {
            let document_of = |(shape, files): (&str, &FileSequence)| json!({ "shape": shape, "files": files.name, "ends": files.ends(), "count": files.count() });
            document["sequences"] = sequences(&model).map(document_of).collect();
        }
        if !numbers.is_empty() {
            document["morph"] =
                numbers.iter().map(|(frame, report)| json!({ "frame": frame, "report": report })).collect();
        }
        if let Some(hollows) = &hollows {
            let volume: f64 = hollows.iter().sum();
            document["hollows"] = json!({ "frame": shot.first, "count": hollows.len(), "volume": volume });
        }
        if !trees.is_empty() {
            document["adf"] = trees.iter().map(|(tree, report)| json!({ "tree": tree, "report": report })).collect();
        }
        super::print_json(&document)?;
    } else {
        let mut text = if global.verbose { settings(&model) } else { String::new() };
        for (shape, files) in sequences(&model) {
            let _ = writeln!(text, "`{shape}`: {files}");
        }
        let size = prepared.extent.size();
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "frames {}-{} ({count})\nbox {about}{:.4} x {:.4} x {:.4} {}\nvoxel size {about}{}\n\
             about {:.2e} voxels, {} of memory (limit {limit}), at most {} a file before compression\n",
            shot.first,
            shot.last,
            size.x,
            size.y,
            size.z,
            model.unit,
            bake::rounded(voxel_size, 9),
            estimate.voxels,
            estimate.memory,
            estimate.file
        );
        if let count @ 1.. = model.set_operations() {
            let _ = writeln!(text, "{count} set operation{}", if count == 1 { "" } else { "s" });
        }
        if let Some(hollows) = &hollows {
            let volume: f64 = hollows.iter().sum();
            let _ = match hollows.len() {
                0 => writeln!(text, "no closed hollows in frame {}", shot.first),
                count => writeln!(
                    text,
                    "{count} closed hollow{} in frame {}, {volume:.3e} {}³ in all: a printer's powder or resin stays in them",
                    if count == 1 { "" } else { "s" },
                    shot.first,
                    model.unit
                ),
            };
        }
        for (tree, report) in &trees {
            let Report { depth, cells, corners, hanging, bytes, .. } = report;
            let size = bake::Bytes(*bytes as u64);
            let _ = writeln!(
                text,
                "adf: {tree} of depth {depth}, {cells} leaves, {corners} corners of which {hanging} hang, {size}"
            );
        }
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

/// The files by frame of all shapes.
fn sequences(model: &Model) -> impl Iterator<Item = (&str, &FileSequence)> {
    model.shapes.iter().flat_map(|shape| shape.sequences().map(|files| (shape.name.as_str(), files)))
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
