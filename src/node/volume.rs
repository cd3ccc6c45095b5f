//! From a grid of a file to colours or scalars everywhere.

use std::path::Path;

use glam::{DVec3, IVec3};

use crate::attribute::{Primaries, ValueBlocks, VoxelValues};
use crate::grid::{BLOCK_EDGE, BLOCK_VOXELS, BlockMask, mask};
use crate::vdb::walk::GridLayout;
use crate::vdb::{INTEROP_ID, MetadataValue, Opened, SparseBlocks, StoredGrid, Tile, Voxels};

use crate::node::model::VoxelSource;
use crate::text::diagnostic::{clip, listed, nearest};
use crate::text::files::{FilePlace, FileReference};
use crate::text::problem::Problem;

/// What a volume may take where nobody says, as an object that is measured.
const MEMORY_LIMIT: usize = 4 << 30;

/// What is read from a grid: attributes of `N` numbers.
pub(crate) struct Wanted<const N: usize> {
    /// What they are called.
    plural: &'static str,
    /// The types of grids that they are in, the usual one first.
    types: [&'static str; 2],
    blocks: fn(Voxels) -> Option<SparseBlocks<[f32; N]>>,
    /// A value as the scene has it, where the file has it in some primaries.
    own: fn([f32; N], Primaries) -> [f32; N],
}

/// Colours, scene-linear.
pub(crate) const COLOURS: Wanted<3> = Wanted {
    plural: "colours",
    types: ["vec3s", "vec3d"],
    blocks: |voxels| if let Voxels::Vectors(blocks) = voxels { Some(blocks) } else { None },
    own: |colour, primaries| primaries.to_rec709(colour),
};

/// Velocities, world units a second.
pub(crate) const VELOCITIES: Wanted<3> = Wanted { plural: "velocities", own: |velocity, _| velocity, ..COLOURS };

/// Scalars; of a level set the distance, positive inside.
pub(crate) const SCALARS: Wanted<1> = Wanted {
    plural: "attributes",
    types: ["float", "double"],
    blocks: |voxels| {
        let Voxels::Floats(SparseBlocks { origins, values, active, tiles, background }) = voxels else { return None };
        let tile = |Tile { origin, edge, value, active }| Tile { origin, edge, value: [value], active };
        Some(SparseBlocks {
            origins,
            values: values.into_iter().map(|block| block.map(|value| [value])).collect(),
            active,
            tiles: tiles.into_iter().map(tile).collect(),
            background: [background],
        })
    },
    own: |value, _| value,
};

impl VoxelSource {
    /// Whether another one, wherever it is named, means the same.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        self.file.place == other.file.place && self.grid == other.grid && self.outside == other.outside
    }
}

/// Reads the grid, or says what is wrong with it. What it will take is known before it is decoded.
pub(crate) fn load<const N: usize>(
    wanted: &Wanted<N>,
    source: &VoxelSource,
    memory_limit: Option<usize>,
) -> Result<VoxelValues<N>, Problem> {
    let opened = opened(&source.file)?;
    let layout = chosen(wanted, source, &opened)?;
    let problem =
        |text: &str| Problem::new(source.grid_span, format!("grid '{}' of {}", name(source), file(source)) + text);
    let empty = || problem(" has no active voxels").help(format!("{} are taken from active voxels", wanted.plural));
    let tree = opened.layout.tree(layout).ok_or_else(empty)?;
    if tree.active_voxels == 0 {
        return Err(empty());
    }
    let tiles = if tree.active_tiles > 0 { tree.active_voxels / BLOCK_VOXELS as u64 } else { 0 };
    // The file, its decoded leaves and these values are there at one time.
    let blocks = tree.leaves.saturating_mul(2).saturating_add(tiles);
    let needed = VoxelValues::<N>::bytes(blocks, tree.active_voxels, source.outside).saturating_add(opened.size());
    if let Some(text) = too_much(needed, memory_limit) {
        return Err(problem(&format!(" {text}")).help(LESS));
    }
    let primaries = match layout.metadata.get(INTEROP_ID) {
        Some(MetadataValue::Text(name)) if name != "unknown" => Primaries::named(name).ok_or_else(|| {
            let known: Vec<&str> = Primaries::NAMES.iter().map(|(name, _)| *name).collect();
            problem(&format!(" has colours in `{}`", clip(name)))
                .help(format!("what can be read is {}", listed(&known)))
        })?,
        _ => Primaries::Rec709,
    };
    let stored = opened.grid(layout).map_err(|error| Problem::new(source.file.span, error.to_string()))?;
    let found = stored.and_then(|StoredGrid { voxels, transform, .. }| Some(((wanted.blocks)(voxels)?, transform)));
    let Some((blocks, transform)) = found else { return Err(wrong_type(wanted, source, &opened, layout)) };
    drop(opened);
    let place = transform.uniform_voxel_size().zip(transform.world(DVec3::ZERO));
    let Some((voxel_size, origin)) = place else {
        return Err(problem(" has voxels that are no cubes along the axes").help("resample it onto such a grid"));
    };
    let mut blocks = value_blocks(blocks, voxel_size, origin);
    if primaries != Primaries::Rec709 {
        for value in blocks.values.iter_mut().flatten() {
            *value = (wanted.own)(*value, primaries);
        }
    }
    let sound = |(mask, values): (&BlockMask, &[[f32; N]; BLOCK_VOXELS])| {
        mask::places(mask).all(|place| values[place].iter().all(|value| value.is_finite()))
    };
    if !blocks.active.iter().zip(&blocks.values).all(sound) {
        return Err(problem(" has active voxels without a finite value").help("write it again without them"));
    }
    VoxelValues::new(blocks, source.outside).ok_or_else(empty)
}

/// What to do about a volume that takes too much memory.
pub(crate) const LESS: &str = "write it with larger voxels, or allow more memory";

/// In words, where a volume would take more memory than the limit, in bytes.
pub(crate) fn too_much(needed: u64, limit: Option<usize>) -> Option<String> {
    let limit = limit.unwrap_or(MEMORY_LIMIT) as u64;
    let text = || format!("would take about {} MB of memory, and the limit is {} MB", needed >> 20, limit >> 20);
    (needed > limit).then(text)
}

/// A file, walked.
pub(crate) fn opened(file: &FileReference) -> Result<Opened, Problem> {
    let opened = match &file.place {
        FilePlace::Disk(path) if !path.is_file() => {
            // A pipe or a device might never end.
            return Err(Problem::new(file.span, format!("{} is not a regular file", file.name())));
        }
        FilePlace::Disk(path) => Opened::open(path),
        FilePlace::BuiltIn(name) => Opened::from_bytes(file.read().unwrap_or_default(), Path::new(name)),
    };
    opened.map_err(|error| Problem::new(file.span, error.to_string()))
}

/// The grid of the name; of several, the first.
fn chosen<'o, const N: usize>(
    wanted: &Wanted<N>,
    source: &VoxelSource,
    opened: &'o Opened,
) -> Result<&'o GridLayout, Problem> {
    let grids = &opened.layout.grids;
    let Some(found) = grids.iter().find(|grid| grid.name == source.grid) else {
        let problem = Problem::new(source.grid_span, format!("{} has no grid '{}'", file(source), name(source)));
        return Err(match nearest(&source.grid, usable(wanted, opened)) {
            Some(near) => problem.help(format!("did you mean `{near}`?")),
            None => problem.help(there_is(wanted, opened)),
        });
    };
    if wanted.types.contains(&found.value_type()) { Ok(found) } else { Err(wrong_type(wanted, source, opened, found)) }
}

fn wrong_type<const N: usize>(wanted: &Wanted<N>, source: &VoxelSource, opened: &Opened, grid: &GridLayout) -> Problem {
    let Wanted { plural, types: [usual, _], .. } = wanted;
    let found = clip(grid.value_type());
    let problem = format!("grid '{}' of {} is of type {found}, and {plural} are {usual}", name(source), file(source));
    Problem::new(source.grid_span, problem).help(there_is(wanted, opened))
}

/// The names of grids that can be read.
fn usable<'o, const N: usize>(wanted: &Wanted<N>, opened: &'o Opened) -> impl Iterator<Item = &'o str> {
    let grids = opened.layout.grids.iter().filter(|grid| wanted.types.contains(&grid.value_type()));
    grids.map(|grid| grid.name.as_str())
}

/// What the file has instead.
fn there_is<const N: usize>(wanted: &Wanted<N>, opened: &Opened) -> String {
    let names: Vec<&str> = usable(wanted, opened).collect();
    if !names.is_empty() {
        return format!("its grids of {}: {}", wanted.plural, listed(&names));
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
fn value_blocks<const N: usize>(grid: SparseBlocks<[f32; N]>, voxel_size: f64, origin: DVec3) -> ValueBlocks<N> {
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
    ValueBlocks { voxel_size, origin, origins, values, active }
}
