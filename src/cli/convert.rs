//! `hfvdb convert`: a mesh becomes a `.vdb`, without a scene file.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::failure::Failure;
use super::options::{Global, Sampling, Writing};
use super::paths;
use super::writing::{Request, write_frames};
use crate::bake::{Source, output};
use crate::node;
use crate::text::Overrides;

/// Arguments of `hfvdb convert`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  hfvdb convert fox.glb -o fox.vdb                      256 voxels along the longest side, with its pictures' colours
  hfvdb convert fox.glb -o fox.vdb --voxel-size 0.01    finer or coarser
  hfvdb convert fox.glb -o fog.vdb --density            with a fog volume, and colours through the inside
  hfvdb convert scan.ply -o scan.vdb --sign winding     a scan with holes
  hfvdb convert leaf.obj -o leaf.vdb --thickness 0.02   a sheet that encloses nothing")]
pub struct Arguments {
    /// The mesh: .obj, .ply, .stl, .gltf, .glb
    #[arg(value_name = "MESH", value_parser = paths::path())]
    mesh: PathBuf,

    /// The axis that points up in the file; the .vdb has z up [default: z; y of glTF]
    #[arg(long, value_name = "AXIS", value_parser = ["y", "z"])]
    up: Option<String>,

    /// What is inside of a surface with holes: winding closes them by sheets [default: an error]
    #[arg(long, value_name = "RULE", value_parser = ["closed", "winding"])]
    sign: Option<String>,

    /// A sheet of this thickness along the surface in place of what it encloses
    #[arg(long, value_name = "UNITS")]
    thickness: Option<f64>,

    /// Add a fog volume, and take colours through the inside
    #[arg(long)]
    density: bool,

    /// Leave out the mesh's colours
    #[arg(long)]
    no_color: bool,

    #[command(flatten)]
    writing: Writing,
    #[command(flatten)]
    sampling: Sampling,
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let pattern = output::pattern(&arguments.writing.output)?;
    let mut set = Vec::new();
    set.extend(arguments.up.as_ref().map(|axis| format!("shape.mesh.up=\"{axis}\"")));
    set.extend(arguments.sign.as_ref().map(|rule| format!("shape.mesh.sign=\"{rule}\"")));
    set.extend(arguments.thickness.map(|thickness| format!("shape.mesh.thickness={thickness}")));
    let grids = ["surface"].into_iter().chain(arguments.density.then_some("density"));
    let grids: Vec<&str> = grids.chain((!arguments.no_color).then_some("Cd")).collect();
    set.push(format!("output.grids={grids:?}"));
    let overrides = Overrides { set, variant: None };
    let model = Arc::new(node::mesh_as_it_is(&arguments.mesh, &overrides)?);
    let source = Source { scene: arguments.mesh.display().to_string(), variant: None, set: overrides.set };
    let request = Request { model, source, pattern, writing: &arguments.writing, sampling: &arguments.sampling };
    write_frames(&request, global)
}
