//! `hfvdb verify`: frames held against their manifests and records.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::failure::Failure;
use super::options::Global;
use super::{job, paths, signals};
use crate::bake::{self, Bytes, Finding, Frames, Sequence, Verdict};
use crate::terminal;

/// Arguments of `hfvdb verify`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  hfvdb verify out                        every sequence in the folder
  hfvdb verify 'out/cubism.####.vdb'      one sequence
  hfvdb verify out/cubism.manifest.json   the same, by its manifest
  hfvdb verify out --json                 one document for a farm

Frames that are missing, changed by as little as a bit, of another bake than most, or foreign to the sequence make
exit code 1, each with what is wrong. Other files in the folder are left alone.")]
pub struct Arguments {
    /// Folders, frame patterns or manifests
    #[arg(value_name = "FOLDER, PATTERN or MANIFEST", required = true, value_parser = paths::path())]
    what: Vec<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let interrupt = job::interrupt()?;
    let (mut verdicts, mut loose, mut seen) = (Vec::new(), Vec::new(), BTreeSet::new());
    for path in &arguments.what {
        let (sequences, findings) = sequences(path)?;
        loose.extend(findings);
        for sequence in sequences {
            if !seen.insert(sequence.display()) {
                continue;
            }
            let verdict = bake::verify(&sequence, &interrupt)?;
            verdicts.push(verdict.ok_or_else(signals::interrupted)?);
        }
    }
    let problems = loose.len() + verdicts.iter().map(|verdict| verdict.findings.len()).sum::<usize>();
    if global.json {
        super::print_json(&json!({ "whole": problems == 0, "sequences": verdicts, "findings": loose }))?;
    } else {
        super::print(&verdicts.iter().map(in_words).collect::<String>())?;
    }
    if problems == 0 {
        return Ok(());
    }
    let all: Vec<Finding> =
        loose.into_iter().chain(verdicts.into_iter().flat_map(|verdict| verdict.findings)).collect();
    for line in grouped(&all) {
        super::say(&line);
    }
    let files = if problems == 1 { "1 file is".into() } else { format!("{problems} files are") };
    let way_out =
        if all.iter().any(|finding| finding.resumes) { "; `hfvdb bake` with --resume bakes frames again" } else { "" };
    Err(Failure::work(format!("{files} not as they should be{way_out}")).with_results())
}

/// The sequences that an argument means, and what is wrong with files that tell of none.
fn sequences(path: &Path) -> Result<(Vec<Sequence>, Vec<Finding>), Failure> {
    if path.is_dir() {
        let (sequences, findings) = bake::sequences(path)?;
        if sequences.is_empty() && findings.is_empty() {
            let problem = "nothing to verify: no manifest and no record of hfvdb in this folder";
            return Err(Failure::work(format!("{}: {problem}", terminal::path(path))));
        }
        return Ok((sequences, findings));
    }
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    if !name.ends_with(".json") && bake::output::format_of(path).is_none() && !path.exists() {
        return Err(Failure::work(format!(
            "{}: there is no such folder; a pattern ends in .vdb",
            terminal::path(path)
        )));
    }
    if !name.ends_with(".json") {
        return Ok((vec![Sequence { pattern: bake::output::pattern(path)? }], Vec::new()));
    }
    if !path.exists() {
        return Err(Failure::work(format!("{}: there is no such manifest", terminal::path(path))));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let (sequences, findings) = bake::sequences(folder)?;
    let its = |manifest: &Path| manifest.file_name() == path.file_name();
    let sequences: Vec<_> = sequences.into_iter().filter(|sequence| its(&sequence.manifest())).collect();
    let findings: Vec<_> = findings.into_iter().filter(|finding| its(&finding.path)).collect();
    if sequences.is_empty() && findings.is_empty() {
        return Err(Failure::work(format!("{}: this is no manifest of hfvdb", terminal::path(path))));
    }
    Ok((sequences, findings))
}

fn in_words(verdict: &Verdict) -> String {
    let Verdict { sequence, frames, bytes, findings } = verdict;
    let frames = if *frames == 1 { "1 frame".into() } else { format!("{frames} frames") };
    match findings.len() {
        0 => format!("{sequence}: {frames}, {}, whole\n", Bytes(*bytes)),
        1 => format!("{sequence}: {frames}, 1 problem\n"),
        count => format!("{sequence}: {frames}, {count} problems\n"),
    }
}

/// Findings as lines; frames with the same problem share one.
fn grouped(findings: &[Finding]) -> Vec<String> {
    let mut groups: Vec<(&Finding, Vec<i64>)> = Vec::new();
    for finding in findings {
        let same = |other: &Finding| {
            finding.frame.is_some()
                && other.frame.is_some()
                && other.problem == finding.problem
                && other.path.parent() == finding.path.parent()
        };
        match (groups.iter_mut().find(|(first, _)| same(first)), finding.frame) {
            (Some((_, frames)), Some(frame)) => frames.push(frame),
            (_, frame) => groups.push((finding, frame.into_iter().collect())),
        }
    }
    let line = |(finding, frames): (&Finding, Vec<i64>)| match Frames::of_numbers(frames.iter().copied()) {
        Some(list) if frames.len() > 1 => {
            format!("frames {list} ({} and so on): {}", terminal::path(&finding.path), finding.problem)
        }
        _ => format!("{}: {}", terminal::path(&finding.path), finding.problem),
    };
    groups.into_iter().map(line).collect()
}
