//! `hfvdb morph`: one mesh becomes another, without a scene file.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::failure::Failure;
use super::options::{Global, Sampling, Writing};
use super::paths;
use super::writing::{Request, write_frames};
use crate::bake::{Source, output};
use crate::node;
use crate::text::{FrameRange, Overrides};

/// Arguments of `hfvdb morph`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  hfvdb morph fox.obj crab.obj -o 'out/fox.####.vdb'                    48 frames
  hfvdb morph fox.obj crab.obj -o 'out/fox.####.vdb' --shot 1001-1096   longer, with the show's numbers
  hfvdb morph fox.obj crab.obj -o 'out/fox.####.vdb' --resume           what is missing of them")]
pub struct Arguments {
    /// The mesh of the first frame (.obj, .ply), with vertex colours if it has any
    #[arg(value_name = "FROM", value_parser = paths::path())]
    from: PathBuf,

    /// The mesh of the last frame
    #[arg(value_name = "TO", value_parser = paths::path())]
    to: PathBuf,

    /// The frames over which the morph runs
    #[arg(long, value_name = "FIRST-LAST", default_value = "1-48", allow_hyphen_values = true)]
    shot: FrameRange,

    /// How much the shapes flow through one body: 0.05 the shortest way, 1.5 very much [default: 0.5]
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true)]
    bridge: Option<f64>,

    /// The axis that points up in both files: y for OBJ by Blender's default export [default: z]
    #[arg(long, value_name = "AXIS", value_parser = ["y", "z"])]
    up: Option<String>,

    /// Colour space in which colours are mixed [default: oklab]
    #[arg(long, value_name = "NAME")]
    color_space: Option<String>,

    #[command(flatten)]
    writing: Writing,
    #[command(flatten)]
    sampling: Sampling,
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let pattern = output::pattern(&arguments.writing.output)?;
    if arguments.shot.count() < 2 {
        return Err(Failure::usage("--shot: a morph runs over a range of at least two frames, such as 1-48"));
    }
    let set = |key: &str, value: Option<String>| value.map(|value| format!("morph.{key}={value}"));
    let up = |shape: &str| arguments.up.as_ref().map(|axis| format!("shape.{shape}.up=\"{axis}\""));
    let overrides = Overrides {
        set: [
            up("from"),
            up("to"),
            set("bridge", arguments.bridge.map(|bridge| bridge.to_string())),
            set("color_space", arguments.color_space.as_ref().map(|space| format!("\"{space}\""))),
        ]
        .into_iter()
        .flatten()
        .collect(),
        variant: None,
    };
    let model = node::morph_of_meshes(&arguments.from, &arguments.to, arguments.shot, &overrides)?;
    let source = Source {
        scene: format!("morph of {} and {}", arguments.from.display(), arguments.to.display()),
        variant: None,
        set: overrides.set,
    };
    let model = Arc::new(model);
    let request = Request { model, source, pattern, writing: &arguments.writing, sampling: &arguments.sampling };
    write_frames(&request, global)
}
