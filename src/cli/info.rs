//! `hfvdb info`: what a `.vdb` file holds.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;

use super::failure::Failure;
use super::options::Global;
use super::{files, paths};
use crate::bake::Bytes;
use crate::mesh::is_mesh;
use crate::terminal;
use crate::vdb::{self, FileInfo, GridInfo};

/// Arguments of `hfvdb info`.
#[derive(Args)]
pub struct Arguments {
    /// Files of any maker, by name or frame pattern
    #[arg(value_name = "FILE", required = true, value_parser = paths::text())]
    files: Vec<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    files::none_is_nanovdb(&arguments.files)?;
    let mut documents = Vec::new();
    for path in files::named(&arguments.files, None)? {
        let path = PathBuf::from(path);
        if is_mesh(&path) {
            return Err(Failure::usage(format!(
                "{}: `hfvdb check` tells of meshes; info takes .vdb files",
                terminal::path(&path)
            )));
        }
        let info = vdb::inspect(&path)?;
        if global.json {
            let mut document = serde_json::to_value(&info).map_err(|error| Failure::work(error.to_string()))?;
            document["path"] = serde_json::json!(path);
            documents.push(document);
        } else {
            super::print(&format!("{}\n{}", terminal::path(&path), in_words(&info)))?;
        }
    }
    if global.json { super::print_json(&serde_json::json!({ "files": documents })) } else { Ok(()) }
}

fn in_words(info: &FileInfo) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "  {}, format {}, written by OpenVDB {}", Bytes(info.bytes), info.format, info.library);
    for (name, value) in &info.metadata {
        let _ = writeln!(text, "  {}", terminal::one_line(&format!("{name}: {value}")));
    }
    for grid in &info.grids {
        text.push_str(&grid_in_words(grid));
    }
    text
}

fn grid_in_words(grid: &GridInfo) -> String {
    let mut lines = Vec::new();
    let vector_type = grid.vector_type.as_ref().map(|kind| format!(", {kind}")).unwrap_or_default();
    let bits = match grid.value_type.as_str() {
        _ if grid.half => ", 16-bit",
        "double" | "vec3d" | "int64" => ", 64-bit",
        "float" | "vec3s" | "int32" | "vec3i" => ", 32-bit",
        _ => "",
    };
    lines.push(format!(
        "grid {}: {}, {}{vector_type}{bits}, {}",
        grid.name, grid.value_type, grid.class, grid.compression
    ));
    if let Some(parent) = &grid.shares_tree_of {
        lines.push(format!("shares the voxels of {parent}"));
    }
    if let Some([x, y, z]) = grid.voxel_size {
        let cubic = x == y && y == z;
        lines.push(if cubic { format!("voxel size {x}") } else { format!("voxel size {x} x {y} x {z}") });
    }
    if let (Some(voxels), Some(leaves)) = (grid.active_voxels, grid.leaves) {
        lines.push(format!("{voxels} active voxels, {leaves} leaves"));
    }
    if let Some(range) = &grid.range {
        let values = match range.least.is_empty() {
            true => "no value is a finite number".into(),
            false => format!("values {:?} to {:?}", range.least, range.greatest),
        };
        let not_finite =
            if range.not_finite > 0 { format!(", {} not finite", range.not_finite) } else { String::new() };
        lines.push(format!("{values}{not_finite}"));
    }
    if let Some(background) = &grid.background {
        lines.push(format!("background {background:?}"));
    }
    if let Some([least, greatest]) = grid.index_box {
        lines.push(format!("voxels {least:?} to {greatest:?}"));
    }
    if let Some([least, greatest]) = grid.world_box {
        lines.push(format!("box {least:.6?} to {greatest:.6?}"));
    }
    let mut text = format!("  {}\n", terminal::one_line(&lines[0]));
    for line in &lines[1..] {
        text.push_str(&format!("    {}\n", terminal::one_line(line)));
    }
    text
}
