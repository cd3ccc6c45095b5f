//! `hfvdb usd`: a USD layer of `.vdb` files.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::failure::Failure;
use super::options::Global;
use super::{files, paths};
use crate::bake::{FrameFile, Layer, LayerOptions, usd_layer};
use crate::disk;
use crate::terminal;

/// Arguments of `hfvdb usd`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  hfvdb usd 'out/cubism.####.vdb' -o out/cubism.usda     one Volume that plays: Solaris, Blender, usdview
  hfvdb usd heart.vdb -o heart.usda                      one file, shown at any time
  hfvdb usd sim.*.vdb -o sim.usda --up y --fps 25        files of another maker, with what they do not say

The layer names the files by paths relative to itself and copies none: move both together. Each grid is an OpenVDBAsset,
found by its own name (field:Cd) and by the one that Hydra's renderers look for (field:color, field:velocity). Frame
numbers are time codes.")]
pub struct Arguments {
    /// Files of any maker, a folder of them, or a frame pattern
    #[arg(value_name = "FRAMES", required = true, value_parser = paths::text())]
    files: Vec<String>,

    /// The layer to write, .usda
    #[arg(short, long, value_name = "FILE", value_parser = paths::path())]
    output: PathBuf,

    /// Frames a second [default: as the files say, else 24]
    #[arg(long, value_name = "RATE", value_parser = rate)]
    fps: Option<f64>,

    /// The axis that points up in the files [default: as they say, else z]
    #[arg(long, value_name = "AXIS", value_parser = ["y", "z"])]
    up: Option<String>,

    /// Replace the layer if it exists
    #[arg(long)]
    overwrite: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let output = &arguments.output;
    let shown = terminal::path(output);
    if !output.extension().is_some_and(|end| end.eq_ignore_ascii_case("usda")) {
        return Err(Failure::usage(format!(
            "{shown}: a layer is text and its name ends in .usda; `usdcat` makes .usdc of it"
        )));
    }
    files::none_is_nanovdb(&arguments.files)?;
    if let Some(other) = arguments.files.iter().find(|file| !files::is_vdb(file) && !Path::new(file).is_dir()) {
        let problem = "usd takes .vdb files; of polygons other programs make USD, of .glb by importing it";
        return Err(Failure::usage(format!("{}: {problem}", terminal::one_line(other))));
    }
    let untouched = |error| match error {
        disk::Error::Exists { .. } => {
            Failure::work(format!("{shown} exists: replace it with --overwrite, or choose another name"))
        }
        error => Failure::work(error.to_string()),
    };
    disk::check_target(output, arguments.overwrite).map_err(untouched)?;
    let files = files::of_all(&arguments.files)?;
    if let Some(file) = files.iter().find(|file| file.contains(char::is_control)) {
        return Err(Failure::work(format!("{}: USD takes no such character in a name", terminal::one_line(file))));
    }
    let frames = by_frame(&files).map_err(Failure::usage)?;
    let up = ["y", "z"].into_iter().find(|axis| arguments.up.as_deref() == Some(axis));
    let Layer { text, warnings } = usd_layer(&frames, output, &LayerOptions { fps: arguments.fps, up })?;
    for warning in &warnings {
        global.warn(&terminal::one_line(warning));
    }
    let written = if arguments.overwrite {
        disk::write_whole(output, text.as_bytes())
    } else {
        disk::write_new(output, text.as_bytes())
    };
    written.map_err(untouched)?;
    if global.json {
        return super::print_json(&json!({ "path": output, "frames": frames.len(), "warnings": warnings }));
    }
    super::print(&format!("{}\n", output.display()))
}

/// Frames a second: finite and positive.
fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse::<f64>().ok().filter(|rate| rate.is_finite() && *rate > 0.0);
    rate.ok_or_else(|| "it must be a number greater than 0, such as 24 or 23.976".into())
}

/// The files by the number in their names that tells them apart.
fn by_frame(files: &[String]) -> Result<Vec<FrameFile>, String> {
    let [first, ..] = files else { return Ok(Vec::new()) };
    if files.len() == 1 {
        return Ok(vec![FrameFile { frame: 0, path: first.into() }]);
    }
    let unclear = |problem: &str| format!("{}: {problem}", terminal::one_line(first));
    let named: Vec<Name> = files.iter().map(|file| Name::of(file)).collect();
    if let Some(at) = named.iter().position(|name| name.letters != named[0].letters) {
        let other = terminal::one_line(&files[at]);
        return Err(unclear(&format!(
            "its name and that of {other} differ by more than a number: name one sequence at a time"
        )));
    }
    let numbers = 0..named[0].numbers.len();
    let vary: Vec<usize> =
        numbers.filter(|&at| named.iter().any(|name| name.numbers[at] != named[0].numbers[at])).collect();
    let [at] = vary[..] else {
        return Err(unclear("no single number in the names tells the files apart, so their frames are not known"));
    };
    let mut frames: Vec<FrameFile> =
        files.iter().zip(&named).map(|(file, name)| FrameFile { frame: name.numbers[at], path: file.into() }).collect();
    frames.sort_by_key(|file| file.frame);
    match frames.windows(2).find(|pair| pair[0].frame == pair[1].frame) {
        None => Ok(frames),
        Some(pair) => {
            let [one, other] = [0, 1].map(|at| terminal::path(&pair[at].path));
            Err(format!("{one} and {other} are both frame {}", pair[0].frame))
        }
    }
}

/// A file's name, taken apart: what stands between its numbers, and the numbers.
struct Name {
    letters: Vec<String>,
    numbers: Vec<i64>,
}

impl Name {
    fn of(file: &str) -> Self {
        let name = Path::new(file).file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let (mut letters, mut numbers) = (vec![String::new()], Vec::new());
        let mut rest = name.as_str();
        while let Some(next) = rest.chars().next() {
            let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
            let Ok(number) = rest[..digits].parse::<i64>() else {
                // A letter, or more digits than a frame has.
                let taken = digits.max(next.len_utf8());
                letters.last_mut().expect("there is always a last one").push_str(&rest[..taken]);
                rest = &rest[taken..];
                continue;
            };
            numbers.push(number);
            letters.push(String::new());
            rest = &rest[digits..];
        }
        // Frames before 0 have their sign before the number: `m.-003.vdb`.
        for (number, before) in numbers.iter_mut().zip(&mut letters) {
            if let Some(plain) = before.strip_suffix('-').filter(|plain| plain.ends_with(['.', '_'])) {
                (*number, *before) = (-*number, plain.to_owned());
            }
        }
        Self { letters, numbers }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(files: &[&str]) -> Result<Vec<i64>, String> {
        let files: Vec<String> = files.iter().map(|file| (*file).to_owned()).collect();
        by_frame(&files).map(|files| files.iter().map(|file| file.frame).collect())
    }

    #[test]
    fn frames_are_told_by_the_number_that_varies() {
        for (files, numbers) in [
            (&["m.0010.vdb", "m.0002.vdb"][..], &[2, 10][..]),
            (&["a/m_0001_v2.vdb", "a/m_0003_v2.vdb"], &[1, 3]),
            (&["m.-001.vdb", "m.0000.vdb", "m.0001.vdb"], &[-1, 0, 1]),
            (&["m.0001.vdb"], &[0]),
        ] {
            assert_eq!(frames(files).as_deref(), Ok(numbers), "{files:?}");
        }
        for (files, problem) in [
            (&["a.1.vdb", "b.2.vdb"][..], "differ by more than a number"),
            (&["m1.1.vdb", "m2.2.vdb"], "no single number"),
            (&["m.01.vdb", "m.1.vdb"], "no single number"),
            (&["m.1.vdb", "m.01.vdb", "m.2.vdb"], "both frame 1"),
        ] {
            assert!(frames(files).is_err_and(|error| error.contains(problem)), "{files:?}: {:?}", frames(files));
        }
    }
}
