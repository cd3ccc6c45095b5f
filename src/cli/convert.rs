//! `hfvdb convert`: a mesh or voxels become another file, without a scene file.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::failure::Failure;
use super::options::{Global, Sampling, Writing};
use super::writing::{Request, write_frames};
use super::{files, paths};
use crate::bake::{FramePattern, Source, output};
use crate::node::{Beside, Files};
use crate::terminal;
use crate::text::Overrides;

/// Arguments of `hfvdb convert`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  hfvdb convert fox.glb -o fox.vdb                      256 voxels along the longest side, with its pictures' colours
  hfvdb convert fox.glb -o fox.vdb --voxel-size 0.01    finer or coarser
  hfvdb convert fox.glb -o fog.vdb --density            with a fog volume, and colours through the inside
  hfvdb convert scan.ply -o scan.vdb --sign winding     a scan with holes
  hfvdb convert leaf.obj -o leaf.vdb --thickness 0.02   a sheet that encloses nothing
  hfvdb convert smoke.vdb -o smoke.glb --threshold 0.3  the surface of fog, as polygons
  hfvdb convert 'walk.####.ply' -o 'out/walk.####.vdb'  files by frame")]
pub struct Arguments {
    /// The file: a mesh (.obj, .ply, .stl, .gltf, .glb) or voxels of any maker (.vdb); or a frame pattern of such
    #[arg(value_name = "FILE", value_parser = paths::path())]
    file: PathBuf,

    /// The axis that points up in the file; of a mesh it is turned, the .vdb has z up [default: z; y of glTF; that of the .vdb]
    #[arg(long, value_name = "AXIS", value_parser = ["y", "z"])]
    up: Option<String>,

    /// What is inside of a mesh: what it encloses; what it goes round an odd number of times, so that pieces within pieces
    /// are hollows; or, with holes, what it goes round by more than half [default: closed]
    #[arg(long, value_name = "RULE", value_parser = ["closed", "parity", "winding"])]
    sign: Option<String>,

    /// A sheet of this thickness along a mesh in place of what it encloses
    #[arg(long, value_name = "UNITS")]
    thickness: Option<f64>,

    #[command(flatten)]
    voxels: VoxelArguments,

    /// Add a fog volume, and take colours through the inside
    #[arg(long)]
    density: bool,

    #[command(flatten)]
    writing: Writing,
    #[command(flatten)]
    sampling: Sampling,
}

/// What is taken of files of voxels.
#[derive(Args, Clone, Default)]
pub struct VoxelArguments {
    /// Of a .vdb the grid that has the surface [default: its level set, else density, else the first of numbers]
    #[arg(long, value_name = "NAME")]
    grid: Option<String>,

    /// Of fog the value from which on it is solid [default: 0.5]
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    threshold: Option<f64>,

    /// Leave out the colours
    #[arg(long)]
    no_color: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    files::none_is_nanovdb(std::slice::from_ref(&arguments.file))?;
    let pattern = output::pattern(&arguments.writing.output)?;
    let files = Files::new(&arguments.file).map_err(Failure::work)?;
    let mut set = Vec::new();
    let of_mesh = [
        ("--sign", arguments.sign.as_ref().map(|rule| format!("shape.file.sign=\"{rule}\""))),
        ("--thickness", arguments.thickness.map(|thickness| format!("shape.file.thickness={thickness}"))),
    ];
    for (option, change) in of_mesh {
        if change.is_some() && files.are_voxels() {
            return Err(Failure::usage(format!("{option} is about meshes; voxels have an inside, or a --threshold")));
        }
        set.extend(change);
    }
    let VoxelArguments { grid, threshold, .. } = &arguments.voxels;
    if !files.are_voxels() && (grid.is_some() || threshold.is_some()) {
        return Err(Failure::usage("--grid and --threshold are about .vdb files"));
    }
    if let (false, Some(axis)) = (files.are_voxels(), &arguments.up) {
        set.push(format!("shape.file.up=\"{axis}\""));
    }
    let wanted = Wanted {
        files,
        pattern,
        set,
        up: arguments.up.as_deref(),
        voxels: &arguments.voxels,
        density: arguments.density,
        writing: &arguments.writing,
        sampling: &arguments.sampling,
    };
    convert(wanted, global)
}

/// Files, and what they are to become.
pub struct Wanted<'a> {
    pub files: Files,
    pub pattern: FramePattern,
    /// What the scene of the files has beside them.
    pub set: Vec<String>,
    /// The axis that points up in voxels.
    pub up: Option<&'a str>,
    pub voxels: &'a VoxelArguments,
    pub density: bool,
    pub writing: &'a Writing,
    pub sampling: &'a Sampling,
}

/// Writes files anew.
pub fn convert(wanted: Wanted<'_>, global: &Global) -> Result<(), Failure> {
    let Wanted { files, pattern, mut set, up, voxels, density, writing, sampling } = wanted;
    // What is not asked for may be missing.
    let files = match &writing.frames {
        Some(frames) => files.between(frames.ends()),
        None => files,
    };
    let VoxelArguments { grid, threshold, no_color } = voxels;
    if let Some(file) = files.which_is_written(&pattern) {
        let file = terminal::path(&file);
        return Err(Failure::usage(format!("{file} would be written over by what is made of it: choose another name")));
    }
    let becomes = |end: &str| pattern.file(0).extension().is_some_and(|own| own.eq_ignore_ascii_case(end));
    let moves = ["vdb", "nvdb", "usda"].into_iter().any(becomes);
    let mut beside = Beside::default();
    if files.are_voxels() {
        beside = files.look(grid.as_deref()).map_err(Failure::work)?;
        set.extend(grid.as_ref().map(|grid| format!("shape.file.grid={grid:?}")));
        set.extend(threshold.map(|threshold| format!("shape.file.threshold={threshold:?}")));
        set.extend(up.or(beside.up).map(|up| format!("up=\"{up}\"")));
        set.extend(beside.unit.map(|unit| format!("unit=\"{unit}\"")));
        // As fine as the file is.
        let is_fine = sampling.voxel_size.is_none() && sampling.resolution.is_none() && beside.edge > 0.0;
        set.extend(is_fine.then(|| format!("output.voxel_size={:e}", beside.edge)));
        let left_out = [
            (&beside.left_out, "attributes have plain names and cubes as voxels"),
            (&beside.volumes, "one surface is taken, and --density writes a density anew"),
        ];
        for (names, why) in left_out.into_iter().filter(|(names, _)| !names.is_empty()) {
            global.warn(&format!("{}: left out; {why}", terminal::one_line(&names.join(", "))));
        }
        if becomes("obj") && !beside.attributes.is_empty() {
            let names = std::mem::take(&mut beside.attributes).join(", ");
            global.warn(&format!("{names}: left out; .obj has no attributes, write .ply, .glb or .usda"));
        }
        if beside.has_velocity && !moves {
            global.warn("its velocity is left out: of polygons .usda alone holds one");
        }
    }
    let mut grids = vec!["surface"];
    grids.extend(density.then_some("density"));
    grids.extend((!no_color).then_some("Cd"));
    grids.extend((beside.has_velocity && moves).then_some("vel"));
    grids.extend(beside.attributes.iter().map(String::as_str));
    set.push(format!("output.grids={grids:?}"));
    let overrides = Overrides { set, variant: None };
    let model = Arc::new(files.scene(&beside.attributes, &overrides)?);
    let source = Source { scene: files.name(), variant: None, set: overrides.set };
    write_frames(&Request { model, source, pattern, writing, sampling }, global)
}
