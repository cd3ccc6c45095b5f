//! `hfvdb bake`: frames of a scene into files.

use clap::Args;

use super::failure::Failure;
use super::job;
use super::options::{Global, Sampling, SceneArguments, Writing};
use super::writing::{Request, write_frames};
use crate::bake::{Source, output};

/// Arguments of `hfvdb bake`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  hfvdb bake heart -o heart.vdb                               one file
  hfvdb bake cubism -o 'out/cubism.####.vdb'                  the whole shot
  hfvdb bake cubism -o 'out/cubism.####.glb'                  polygons with colours instead: .glb, .ply, .obj
  hfvdb bake cubism -o 'out/cubism.####.vdb' --frames 1-48x4  every fourth frame
  hfvdb bake cubism -o 'out/cubism.####.vdb' --dry-run        what that would write and take
  hfvdb bake cubism -o 'out/cubism.####.vdb' --resume         what is missing or not whole
  hfvdb bake cubism -o 'out/cubism.####.vdb' --frames 13-24 --resume --progress json
                                                              a farm's task, which may be killed
                                                              and sent again")]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    writing: Writing,
    #[command(flatten)]
    sampling: Sampling,
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let pattern = output::pattern(&arguments.writing.output)?;
    let model = job::load(&arguments.scene, global)?;
    let changes = &arguments.scene.changes;
    let source =
        Source { scene: arguments.scene.scene.clone(), variant: changes.variant.clone(), set: changes.set.clone() };
    let request = Request { model, source, pattern, writing: &arguments.writing, sampling: &arguments.sampling };
    write_frames(&request, global)
}
