//! The files that a command line names, one by one or by the pattern that they were baked with.

use std::path::Path;

use super::failure::Failure;
use crate::bake::{FramePattern, Frames, Sequence};
use crate::terminal;

/// Whether an input is a file of voxels, or a pattern of such files.
pub fn is_vdb(input: &str) -> bool {
    Path::new(input).extension().is_some_and(|end| end.eq_ignore_ascii_case("vdb"))
}

/// Refuses inputs that are NanoVDB.
pub fn none_is_nanovdb(inputs: &[impl AsRef<Path>]) -> Result<(), Failure> {
    let is_one = |input: &&Path| input.extension().is_some_and(|end| end.eq_ignore_ascii_case("nvdb"));
    let Some(file) = inputs.iter().map(AsRef::as_ref).find(is_one) else { return Ok(()) };
    let file = terminal::path(file);
    Err(Failure::usage(format!("{file}: hfvdb writes .nvdb and does not read it; bake or convert to .vdb for that")))
}

/// The `.vdb` files of inputs of which some may be folders, each once: those of a folder by name.
pub fn of_all(inputs: &[String]) -> Result<Vec<String>, Failure> {
    let mut files: Vec<String> = Vec::new();
    for input in inputs {
        let found =
            if Path::new(input).is_dir() { of_folder(input)? } else { named(std::slice::from_ref(input), None)? };
        files.extend(found.into_iter().filter(|file| !files.contains(file)).collect::<Vec<_>>());
    }
    Ok(files)
}

fn of_folder(folder: &str) -> Result<Vec<String>, Failure> {
    let unreadable = |error: std::io::Error| Failure::work(format!("{folder}: cannot list this folder: {error}"));
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if let Some(text) = path.to_str().filter(|text| is_vdb(text)) {
            files.push(text.to_owned());
        }
    }
    files.sort();
    if files.is_empty() {
        return Err(Failure::work(format!("{folder}: there is no .vdb file in this folder")));
    }
    Ok(files)
}

/// The files of all inputs. A frame pattern stands for its frames that are in the folder, by number, or for `frames`.
pub fn named(inputs: &[String], frames: Option<&Frames>) -> Result<Vec<String>, Failure> {
    let mut files = Vec::new();
    for input in inputs {
        // A file is what its name says, even a name that could be a pattern.
        let pattern =
            if Path::new(input).exists() { None } else { Some(FramePattern::new(Path::new(input), &["vdb"])?) };
        match pattern.filter(FramePattern::has_token) {
            Some(pattern) => files.extend(of_pattern(&Sequence { pattern }, frames)?),
            None if frames.is_some() => {
                let problem = "--frames picks from a scene or a frame pattern; of files, name those to show";
                return Err(Failure::usage(format!("{input}: {problem}")));
            }
            None => files.push(input.clone()),
        }
    }
    Ok(files)
}

fn of_pattern(sequence: &Sequence, frames: Option<&Frames>) -> Result<Vec<String>, Failure> {
    let pattern = &sequence.pattern;
    let mut numbers: Vec<i64> = sequence.names()?.iter().filter_map(|name| pattern.frame_of(name)).collect();
    numbers.sort_unstable();
    if numbers.is_empty() {
        return Err(Failure::work(format!("{}: there is no frame with such a name", sequence.display())));
    }
    if let Some(frames) = frames {
        let missing = frames.numbers().iter().copied().filter(|frame| numbers.binary_search(frame).is_err());
        if let Some(missing) = Frames::of_numbers(missing) {
            let there = Frames::of_numbers(numbers).map(|there| there.to_string()).unwrap_or_default();
            return Err(Failure::work(format!("{}: no frame {missing}; there is {there}", sequence.display())));
        }
        numbers = frames.numbers().to_vec();
    }
    Ok(numbers.into_iter().map(|number| pattern.file(number).display().to_string()).collect())
}
