//! `hfvdb mesh`: the surface of `.vdb` files of any maker as polygons.

use std::path::PathBuf;

use clap::Args;

use super::convert::{VoxelArguments, Wanted, convert};
use super::failure::Failure;
use super::options::{Global, Sampling, Writing};
use super::{files, paths};
use crate::bake::output;
use crate::node::Files;

/// Arguments of `hfvdb mesh`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  hfvdb mesh out/cubism.0048.vdb -o frame.ply                polygons with colours and attributes at their vertices
  hfvdb mesh 'out/cubism.####.vdb' -o 'out/cubism.####.glb'  all frames of a sequence
  hfvdb mesh 'out/cubism.####.vdb' -o out/cubism.usda        all frames in one USD file
  hfvdb mesh smoke.vdb -o smoke.obj --threshold 0.2          fog, solid from a value on
  hfvdb mesh heart.vdb -o coarse.glb --resolution 64         coarser than the file
  hfvdb mesh heart.vdb -o few.glb --adaptivity 0.1           large triangles where it is flat, a tenth of a voxel away at most

Polygons are as fine as the file's voxels where neither --voxel-size nor --resolution says otherwise, closed, and
face outward. Of a scene `hfvdb bake -o m.####.glb` makes them with sharp edges.")]
pub struct Arguments {
    /// A .vdb file of any maker, a level set or fog; or a frame pattern of such
    #[arg(value_name = "FRAMES", value_parser = paths::path())]
    files: PathBuf,

    /// The axis that points up in the file [default: as it says, else z]
    #[arg(long, value_name = "AXIS", value_parser = ["y", "z"])]
    up: Option<String>,

    #[command(flatten)]
    voxels: VoxelArguments,

    #[command(flatten)]
    writing: Writing,
    #[command(flatten)]
    sampling: Sampling,
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let Arguments { files: path, up, voxels, writing, sampling } = arguments;
    let pattern = output::pattern(&writing.output)?;
    let is_of_voxels = |end: &std::ffi::OsStr| ["vdb", "nvdb"].iter().any(|voxels| end.eq_ignore_ascii_case(voxels));
    if writing.output.extension().is_some_and(is_of_voxels) {
        let problem = "mesh writes polygons: .glb, .usda, .ply or .obj; `hfvdb convert` writes .vdb and .nvdb";
        return Err(Failure::usage(problem));
    }
    files::none_is_nanovdb(std::slice::from_ref(path))?;
    if !files::is_vdb(&path.to_string_lossy()) {
        return Err(Failure::usage("mesh takes .vdb files; `hfvdb convert` takes meshes, `hfvdb bake` scenes"));
    }
    let files = Files::new(path).map_err(Failure::work)?;
    let up = up.as_deref();
    convert(Wanted { files, pattern, set: Vec::new(), up, voxels, density: false, writing, sampling }, global)
}
