//! `hfvdb new`: a first scene, with remarks, to be changed.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde_json::json;

use super::failure::Failure;
use super::options::Global;
use super::paths;
use crate::disk;
use crate::terminal;

/// Arguments of `hfvdb new`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  hfvdb new mine.toml                 one coloured shape
  hfvdb new mine.toml --kind morph    a shape that becomes another one
  hfvdb new mine.toml --kind meshes   two meshes, the one becoming the other; edit their names first")]
pub struct Arguments {
    /// The scene to write; a file that is there stays as it is
    #[arg(value_name = "FILE.toml", value_parser = paths::path())]
    file: PathBuf,

    /// What the scene shows
    #[arg(long, value_enum, default_value_t = Sort::Shape)]
    kind: Sort,
}

/// What a first scene shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Sort {
    /// One coloured shape
    Shape,
    /// A shape that becomes another one
    Morph,
    /// Two meshes, the one becoming the other
    Meshes,
}

impl Sort {
    fn text(self) -> &'static str {
        match self {
            Self::Shape => include_str!("../../scenes/new/shape.toml"),
            Self::Morph => include_str!("../../scenes/new/morph.toml"),
            Self::Meshes => include_str!("../../scenes/new/meshes.toml"),
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let file = &arguments.file;
    let shown = terminal::path(file);
    if file.extension().is_none_or(|ending| ending != "toml") {
        return Err(Failure::usage(format!("{shown}: a scene's name ends in .toml")));
    }
    disk::write_new(file, arguments.kind.text().as_bytes()).map_err(|error| match error {
        disk::Error::Exists { .. } => {
            Failure::work(format!("{shown} is there already and stays as it is: choose another name"))
        }
        error => Failure::work(error.to_string()),
    })?;
    if global.json {
        return super::print_json(&json!({ "path": file }));
    }
    super::print(&format!("{}\n", file.display()))?;
    if !global.quiet {
        super::say(&format!("next: hfvdb preview {shown} -o preview.png --watch --open"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::{Source, load};
    use crate::text::Overrides;

    /// Each is right as it stands. The meshes are the program's own until others are named.
    #[test]
    fn first_scenes_are_right() {
        for kind in Sort::value_variants() {
            let source = Source::Text { name: "new.toml".into(), text: kind.text().into(), folder: ".".into() };
            let model = load(&source, &Overrides::default()).unwrap_or_else(|problems| panic!("{problems}"));
            assert!(model.warnings.is_empty(), "{kind:?}: {}", model.warnings);
        }
    }
}
