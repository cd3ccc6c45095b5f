//! What is in a file, for reports.

use std::path::Path;

use glam::DVec3;
use serde::Serialize;

use super::read::{Opened, StoredClass};
use super::voxels::{SparseBlocks, Voxels};
use super::walk::{CompressionFlags, GridLayout, walk};
use super::{Error, Metadata, metadata_text};

/// A file.
#[derive(Clone, Debug, Serialize)]
pub struct FileInfo {
    /// Its size.
    pub bytes: u64,
    /// Its format, such as 224.
    pub format: u32,
    /// The version of the library that wrote it, such as `10.0`.
    pub library: String,
    /// Metadata of the file.
    pub metadata: Metadata,
    /// Its grids, in the file's order.
    pub grids: Vec<GridInfo>,
}

/// A grid of a file.
#[derive(Clone, Debug, Serialize)]
pub struct GridInfo {
    /// Its name.
    pub name: String,
    /// The type of its values as OpenVDB spells it, such as `float` and `vec3s`, or of its tree where that is another.
    pub value_type: String,
    /// What its values mean.
    pub class: StoredClass,
    /// How vectors follow a transform, as OpenVDB spells it, where the file says so.
    pub vector_type: Option<String>,
    /// Whether its values take 16 bits in the file.
    pub half: bool,
    /// Its compression, such as `blosc + active values`.
    pub compression: String,
    /// The value away from blocks and tiles, as the file has it: of a level set positive. One number or three.
    pub background: Option<Vec<f32>>,
    /// Edges of a voxel in world units.
    pub voxel_size: Option<[f64; 3]>,
    /// The world position of voxel (0, 0, 0).
    pub origin: Option<[f64; 3]>,
    /// The grid whose tree it shares, if it does.
    pub shares_tree_of: Option<String>,
    /// Active voxels, in leaves and tiles.
    pub active_voxels: Option<u64>,
    /// Leaf blocks.
    pub leaves: Option<u64>,
    /// The least and greatest active voxel.
    pub index_box: Option<[[i32; 3]; 2]>,
    /// The box of the active voxels' centres in world units.
    pub world_box: Option<[[f64; 3]; 2]>,
    /// The least and greatest active value, as the file has them; of vectors, of each component.
    pub range: Option<Range>,
    /// Its metadata.
    pub metadata: Metadata,
}

/// The least and the greatest value. Values that are no numbers are counted apart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Range {
    /// One number, or one a component; none where no value is finite.
    pub least: Vec<f32>,
    /// One number, or one a component; none where no value is finite.
    pub greatest: Vec<f32>,
    /// Active values with a component that is not a finite number.
    pub not_finite: u64,
}

/// Reads and summarises a file.
///
/// # Errors
/// Those of [`super::read`].
pub fn inspect(path: impl AsRef<Path>) -> Result<FileInfo, Error> {
    let opened = Opened::open(path.as_ref())?;
    let layout = &opened.layout;
    let grids = layout.grids.iter().map(|grid| describe(&opened, grid)).collect::<Result<_, _>>()?;
    Ok(FileInfo {
        bytes: opened.size(),
        format: layout.format,
        library: format!("{}.{}", layout.library.0, layout.library.1),
        metadata: layout.metadata.clone(),
        grids,
    })
}

/// The box of the active voxels' centres of a file's first level set, in world units; `None` where there are none. From
/// the structure alone: no voxel is decompressed.
///
/// # Errors
/// Those of [`super::walk::walk`].
pub fn level_set_box(path: impl AsRef<Path>) -> Result<Option<[[f64; 3]; 2]>, Error> {
    let layout = walk(path)?;
    let level_set = layout.grids.iter().find(|grid| StoredClass::of(&grid.metadata) == StoredClass::LevelSet);
    Ok(level_set.and_then(|grid| {
        let (low, high) = layout.tree(grid)?.active_box?;
        grid.transform.world_box(low, high)
    }))
}

fn describe(opened: &Opened, grid: &GridLayout) -> Result<GridInfo, Error> {
    let class = StoredClass::of(&grid.metadata);
    let owner = grid.shares_tree_of.as_ref();
    let owner = owner.and_then(|name| opened.layout.grids.iter().find(|other| other.unique_name == *name));
    let tree = opened.layout.tree(grid);
    let voxels = opened.voxels(grid)?;
    // Values are told as they stand in the file, where level sets are negative inside.
    let sign = if class == StoredClass::LevelSet { -1.0 } else { 1.0 };
    let (background, range) = match &voxels {
        Some(Voxels::Floats(blocks)) => (Some(vec![sign * blocks.background]), range(blocks, |value| [sign * value])),
        Some(Voxels::Vectors(blocks)) => (Some(blocks.background.to_vec()), range(blocks, |value| value)),
        None => (None, None),
    };
    let index_box = tree.and_then(|tree| tree.active_box);
    Ok(GridInfo {
        name: grid.name.clone(),
        value_type: grid.value_type().into(),
        class,
        vector_type: metadata_text(&grid.metadata, "vector_type").map(str::to_owned),
        half: grid.half,
        compression: spelled(grid.compression),
        background,
        voxel_size: grid.transform.voxel_size().map(|size| size.to_array()),
        origin: grid.transform.world(DVec3::ZERO).map(|origin| origin.to_array()),
        shares_tree_of: owner.map(|owner| owner.name.clone()),
        active_voxels: tree.map(|tree| tree.active_voxels),
        leaves: tree.map(|tree| tree.leaves),
        index_box: index_box.map(|(low, high)| [low.to_array(), high.to_array()]),
        world_box: index_box.and_then(|(low, high)| grid.transform.world_box(low, high)),
        range,
        metadata: grid.metadata.clone(),
    })
}

/// As OpenVDB spells it.
fn spelled(flags: CompressionFlags) -> String {
    let parts = [(flags.zip, "zip"), (flags.blosc, "blosc"), (flags.active_mask, "active values")];
    let on: Vec<&str> = parts.iter().filter(|(on, _)| *on).map(|(_, name)| *name).collect();
    if on.is_empty() { "none".into() } else { on.join(" + ") }
}

/// The range of the active values, in leaves and tiles; `None` when there are none.
fn range<T: Copy, const N: usize>(blocks: &SparseBlocks<T>, components: impl Fn(T) -> [f32; N]) -> Option<Range> {
    let (mut least, mut greatest, mut not_finite) = ([f32::INFINITY; N], [f32::NEG_INFINITY; N], 0);
    let mut any = false;
    let mut add = |value: T| {
        any = true;
        let value = components(value);
        if !value.iter().all(|component| component.is_finite()) {
            not_finite += 1;
            return;
        }
        for axis in 0..N {
            least[axis] = least[axis].min(value[axis]);
            greatest[axis] = greatest[axis].max(value[axis]);
        }
    };
    for (values, mask) in blocks.values.iter().zip(&blocks.active) {
        for (place, value) in values.iter().enumerate() {
            if mask[place / 64] >> (place % 64) & 1 == 1 {
                add(*value);
            }
        }
    }
    blocks.tiles.iter().filter(|tile| tile.active).for_each(|tile| add(tile.value));
    let found = |ends: [f32; N]| if least[0] <= greatest[0] { ends.to_vec() } else { Vec::new() };
    any.then(|| Range { least: found(least), greatest: found(greatest), not_finite })
}
