//! From a grid of colours in a file to colours everywhere.

use std::path::Path;

use glam::{DVec3, IVec3};

use crate::attribute::{ColourBlocks, VoxelColours};
use crate::grid::{BLOCK_EDGE, BLOCK_VOXELS, BlockMask, mask};
use crate::vdb::walk::GridLayout;
use crate::vdb::{Opened, SparseBlocks, StoredGrid, Tile, Voxels};

use super::diagnostic::{clip, listed, nearest};
use super::error::Problem;
use super::files::FilePlace;
use super::model::VoxelSource;

/// What a volume may take where nobody says, as an object that is measured.
const MEMORY_LIMIT: usize = 4 << 30;

impl VoxelSource {
    /// Whether another one, wherever it is named, means the same.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        self.file.place == other.file.place && self.grid == other.grid && self.outside == other.outside
    }
}

/// Reads the grid, or says what is wrong with it. What it will take is known before it is decoded.
pub(super) fn load(source: &VoxelSource, memory_limit: Option<usize>) -> Result<VoxelColours, Problem> {
    let opened = open(source)?;
    let layout = chosen(source, &opened)?;
    let problem =
        |text: &str| Problem::new(source.grid_span, format!("grid '{}' of {}", name(source), file(source)) + text);
    let empty = || problem(" has no active voxels").help("colours are taken from active voxels");
    let tree = opened.tree(layout).ok_or_else(empty)?;
    if tree.active_voxels == 0 {
        return Err(empty());
    }
    let tiles = if tree.active_tiles > 0 { tree.active_voxels / BLOCK_VOXELS as u64 } else { 0 };
    // The file, its decoded leaves and these colours are there at one time.
    let blocks = tree.leaves.saturating_mul(2).saturating_add(tiles);
    let needed = VoxelColours::bytes(blocks, tree.active_voxels, source.outside).saturating_add(opened.size());
    let limit = memory_limit.unwrap_or(MEMORY_LIMIT) as u64;
    if needed > limit {
        let text = format!(" would take about {} MB of memory, and the limit is {} MB", needed >> 20, limit >> 20);
        return Err(problem(&text).help("write it with larger voxels, or allow more memory"));
    }
    let stored = opened.grid(layout).map_err(|error| Problem::new(source.file.span, error.to_string()))?;
    let Some(StoredGrid { voxels: Voxels::Vectors(blocks), transform, .. }) = stored else {
        return Err(wrong_type(source, &opened, layout));
    };
    drop(opened);
    let place = transform.uniform_voxel_size().zip(transform.world(DVec3::ZERO));
    let Some((voxel_size, origin)) = place else {
        return Err(problem(" has voxels that are no cubes along the axes").help("resample it onto such a grid"));
    };
    let blocks = colour_blocks(blocks, voxel_size, origin);
    let sound = |(mask, values): (&BlockMask, &[[f32; 3]; BLOCK_VOXELS])| {
        mask::places(mask).all(|place| values[place].iter().all(|value| value.is_finite()))
    };
    if !blocks.active.iter().zip(&blocks.values).all(sound) {
        return Err(problem(" has active voxels without a finite colour").help("write it again without them"));
    }
    VoxelColours::new(blocks, source.outside).ok_or_else(empty)
}

fn open(source: &VoxelSource) -> Result<Opened, Problem> {
    let opened = match &source.file.place {
        FilePlace::Disk(path) if !path.is_file() => {
            // A pipe or a device might never end.
            return Err(Problem::new(source.file.span, format!("{} is not a regular file", file(source))));
        }
        FilePlace::Disk(path) => Opened::open(path),
        FilePlace::BuiltIn(name) => Opened::from_bytes(source.file.read().unwrap_or_default(), Path::new(name)),
    };
    opened.map_err(|error| Problem::new(source.file.span, error.to_string()))
}

/// The grid of the name; of several, the first.
fn chosen<'o>(source: &VoxelSource, opened: &'o Opened) -> Result<&'o GridLayout, Problem> {
    let grids = &opened.layout.grids;
    let Some(found) = grids.iter().find(|grid| grid.name == source.grid) else {
        let problem = Problem::new(source.grid_span, format!("{} has no grid '{}'", file(source), name(source)));
        return Err(match nearest(&source.grid, of_colours(opened)) {
            Some(near) => problem.help(format!("did you mean `{near}`?")),
            None => problem.help(there_is(opened)),
        });
    };
    match found.value_type() {
        "vec3s" | "vec3d" => Ok(found),
        _ => Err(wrong_type(source, opened, found)),
    }
}

fn wrong_type(source: &VoxelSource, opened: &Opened, grid: &GridLayout) -> Problem {
    let found = clip(grid.value_type());
    let problem = format!("grid '{}' of {} is of type {found}, and colours are vec3s", name(source), file(source));
    Problem::new(source.grid_span, problem).help(there_is(opened))
}

/// The names of grids that can be colours.
fn of_colours(opened: &Opened) -> impl Iterator<Item = &str> {
    let grids = opened.layout.grids.iter().filter(|grid| matches!(grid.value_type(), "vec3s" | "vec3d"));
    grids.map(|grid| grid.name.as_str())
}

/// What the file has instead.
fn there_is(opened: &Opened) -> String {
    let colours: Vec<&str> = of_colours(opened).collect();
    if !colours.is_empty() {
        return format!("its grids of colours: {}", listed(&colours));
    }
    let grid = |grid: &GridLayout| format!("`{}` ({})", clip(&grid.name), clip(grid.value_type()));
    let grids: Vec<String> = opened.layout.grids.iter().map(grid).collect();
    if grids.is_empty() { "it has no grids".into() } else { format!("there is {}", grids.join(", ")) }
}

fn name(source: &VoxelSource) -> std::borrow::Cow<'_, str> {
    clip(&source.grid)
}

fn file(source: &VoxelSource) -> String {
    source.file.name()
}

/// The grid's blocks, and its active tiles as blocks.
fn colour_blocks(grid: SparseBlocks<[f32; 3]>, voxel_size: f64, origin: DVec3) -> ColourBlocks {
    let SparseBlocks { mut origins, mut values, mut active, tiles, .. } = grid;
    for Tile { origin, edge, value, .. } in tiles.into_iter().filter(|tile| tile.active) {
        let side = edge / BLOCK_EDGE;
        for i in 0..side * side * side {
            let step = IVec3::new(i / (side * side), i / side % side, i % side);
            origins.push(origin + step * BLOCK_EDGE);
            values.push([value; BLOCK_VOXELS]);
            active.push([u64::MAX; 8]);
        }
    }
    ColourBlocks { voxel_size, origin, origins, values, active }
}
