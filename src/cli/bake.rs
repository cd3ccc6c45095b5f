//! `hfvdb bake`: frames of a scene into files.

use clap::Args;

use super::failure::Failure;
use super::job;
use super::options::{Global, Sampling, SceneArguments, Writing};
use super::writing::{Request, write_frames};
use crate::bake::{Source, output};
use crate::vdb::PROGRAM_NAMES;

/// Arguments of `hfvdb bake`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  hfvdb bake heart -o heart.vdb                               one file
  hfvdb bake cubism -o 'out/cubism.####.vdb'                  the whole shot
  hfvdb bake cubism -o 'out/cubism.####.glb'                  polygons with colours instead: .glb, .ply, .obj
  hfvdb bake cubism -o out/cubism.usda                        polygons of all frames in one USD file
  hfvdb bake heart -o heart.vdb --for vray                    the grids as V-Ray looks for them
  hfvdb bake cubism -o 'out/cubism.####.vdb' --frames 1-48x4  every fourth frame
  hfvdb bake cubism -o 'out/cubism.####.vdb' --dry-run        what that would write and take
  hfvdb bake cubism -o 'out/cubism.####.vdb' --resume         what is missing or not whole
  hfvdb bake cubism -o 'out/cubism.####.vdb' --frames 13-24 --resume --progress json
                                                              a farm's task, which may be killed
                                                              and sent again")]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Name the grids as a program looks for them, see docs/output.md; of renderers of fog with a density
    #[arg(long = "for", value_name = "PROGRAM", value_parser = clap::builder::PossibleValuesParser::new(PROGRAM_NAMES))]
    program: Option<String>,

    #[command(flatten)]
    writing: Writing,
    #[command(flatten)]
    sampling: Sampling,
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let pattern = output::pattern(&arguments.writing.output)?;
    let mut scene = arguments.scene.clone();
    scene.changes.set.extend(arguments.program.iter().map(|program| format!("output.for=\"{program}\"")));
    let model = job::load(&scene, global)?;
    let changes = &scene.changes;
    let source = Source { scene: scene.scene.clone(), variant: changes.variant.clone(), set: changes.set.clone() };
    let request = Request { model, source, pattern, writing: &arguments.writing, sampling: &arguments.sampling };
    write_frames(&request, global)
}
