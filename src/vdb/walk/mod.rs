//! The structural walk: a whole `.vdb` parsed in safe Rust. OpenVDB's own reader, which trusts what a file says of itself,
//! never sees it: damaged files crash that one, and it takes many a truncated one for whole.
//!
//! Every length, count, mask and offset is checked here against the bytes that are there: header, metadata, grid
//! descriptors, transforms, tree topology, masks and the frames of compressed buffers. Nothing is allocated on a file's
//! word, and nesting is as deep as the tree, three nodes. What stays unseen is damage inside a compressed buffer whose
//! frame is whole: `decode` opens those, each into as many bytes as the walk has found that it must have.
//!
//! Formats 222 to 225 are read, as OpenVDB 3 to 13 write them. Grids of points, masks and foreign trees are stepped
//! over by their offsets, and said to be so.
//!
//! The names of fields and their order follow the headers of OpenVDB 10: `io/Archive.h`, `io/GridDescriptor.h`,
//! `io/Compression.h`, `tree/RootNode.h`, `tree/InternalNode.h`, `tree/LeafNode.h`, `math/Maps.h`.

mod buffers;
mod cursor;
mod header;
mod topology;
mod transform;

use std::path::Path;

use glam::IVec3;

pub use transform::Transform;

use super::{Error, Metadata};
use crate::disk;
pub(super) use buffers::{Buffer, Inactive, Packing, StoredValues};
pub(super) use cursor::{Failure, damage};
pub(super) use topology::{RootTile, Tree, is_set};

use cursor::Cursor;
use topology::{Leaf, ValueKind};

/// What the walk found in a file.
#[derive(Clone, Debug)]
pub struct Layout {
    /// The file's format, such as 224.
    pub format: u32,
    /// The version of the library that wrote it: major and minor.
    pub library: (u32, u32),
    /// Metadata of the file.
    pub metadata: Metadata,
    /// The grids, in the file's order.
    pub grids: Vec<GridLayout>,
}

impl Layout {
    /// The grid whose tree a grid has.
    pub(super) fn owner<'g>(&'g self, grid: &'g GridLayout) -> &'g GridLayout {
        match &grid.shares_tree_of {
            Some(parent) => self.grids.iter().find(|other| other.unique_name == *parent).unwrap_or(grid),
            None => grid,
        }
    }

    /// What a grid's tree holds, which may be another's; `None` for a type that is not walked.
    pub fn tree<'g>(&'g self, grid: &'g GridLayout) -> Option<&'g TreeLayout> {
        self.owner(grid).tree.as_ref()
    }
}

/// What the walk found of one grid.
#[derive(Clone, Debug)]
pub struct GridLayout {
    /// Its name.
    pub name: String,
    /// Its name made unique in the file: with a separator and a number where names repeat.
    pub(super) unique_name: String,
    /// The type of its tree, such as `Tree_float_5_4_3`.
    pub tree_type: String,
    /// Whether its values take 16 bits in the file.
    pub half: bool,
    /// The grid whose tree it shares, by its unique name.
    pub(super) shares_tree_of: Option<String>,
    /// Its compression.
    pub compression: CompressionFlags,
    /// Its metadata.
    pub metadata: Metadata,
    /// Where its voxels stand.
    pub transform: Transform,
    /// What its tree holds; `None` for a type that is not walked, and for a grid that shares another's tree.
    pub tree: Option<TreeLayout>,
    /// Where its descriptor stands.
    descriptor: usize,
    /// Where its tree begins, where it has one of its own.
    topology: usize,
}

impl GridLayout {
    /// The type of its values as OpenVDB calls it, such as `float` or `vec3s`.
    pub fn value_type(&self) -> &str {
        let name = self.tree_type.strip_prefix("Tree_").and_then(|rest| rest.strip_suffix("_5_4_3"));
        name.unwrap_or(&self.tree_type)
    }
}

/// What a tree holds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TreeLayout {
    /// Leaf blocks.
    pub leaves: u64,
    /// Tiles that are active.
    pub active_tiles: u64,
    /// Active voxels, in leaves and tiles.
    pub active_voxels: u64,
    /// The least and the greatest active voxel, if any.
    pub active_box: Option<(IVec3, IVec3)>,
}

/// How a grid's buffers are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CompressionFlags {
    /// Zip.
    pub zip: bool,
    /// Blosc.
    pub blosc: bool,
    /// Inactive values are left out where they can be restored.
    pub active_mask: bool,
}

/// Walks a file.
///
/// # Errors
/// [`Error::Disk`] when it cannot be read, [`Error::Damaged`] and [`Error::Unsupported`] for what is in it.
pub fn walk(path: impl AsRef<Path>) -> Result<Layout, Error> {
    let path = path.as_ref();
    let bytes = disk::read(path).map_err(|error| Error::system(path, "read it", error))?;
    walk_bytes(&bytes, path)
}

/// Walks the bytes of a file; `path` is for messages.
pub(super) fn walk_bytes(bytes: &[u8], path: &Path) -> Result<Layout, Error> {
    walk_from(Cursor::new(bytes), path)
}

/// Walks the bytes of a file that lie in pieces, none of which ends within a leaf: whether a reader takes them. `path` is
/// for messages.
///
/// # Errors
/// [`Error::Damaged`].
pub fn read_back(pieces: &[Vec<u8>], path: &Path) -> Result<(), Error> {
    walk_from(Cursor::of_pieces(pieces), path).map(drop)
}

fn walk_from(cursor: Cursor, path: &Path) -> Result<Layout, Error> {
    parse(cursor).map_err(|failure| failure.in_file(path))
}

/// The tree of a grid that has one of its own, and the values of its leaves, in the bytes of a file that was walked.
pub(super) fn read_tree<'a>(bytes: &'a [u8], grid: &GridLayout) -> Result<(Tree<'a>, Vec<StoredValues<'a>>), Failure> {
    let Some(kind) = ValueKind::of(&grid.tree_type, grid.half) else {
        return Err(Failure::Unsupported(format!("grid '{}' of type {} is not read", grid.name, grid.tree_type)));
    };
    let mut cursor = Cursor::new(bytes);
    cursor.skip_to(grid.topology as i64, "a tree")?;
    let tree = topology::read(&mut cursor, &kind, grid.compression)?;
    let values = |leaf: &Leaf| buffers::read_leaf(&mut cursor, &kind, grid.compression, leaf.mask);
    let leaves = tree.leaves.iter().map(values).collect::<Result<_, _>>()?;
    Ok((tree, leaves))
}

fn parse(mut cursor: Cursor) -> Result<Layout, Failure> {
    let header = header::read(&mut cursor)?;
    let metadata = header::read_metadata(&mut cursor)?;
    let count_at = cursor.at();
    let count = cursor.i32()?;
    // A descriptor takes at least 40 bytes.
    if count < 0 || count as usize > cursor.remaining() / 40 {
        return damage(count_at, format!("{count} grids do not fit into the {} bytes that follow", cursor.remaining()));
    }
    let mut grids: Vec<GridLayout> = Vec::new();
    for _ in 0..count {
        let grid = header::read_grid(&mut cursor, header.has_offsets)?;
        let known = |name: &String| grids.iter().any(|other| other.unique_name == *name && other.tree.is_some());
        if grids.iter().any(|other| other.unique_name == grid.unique_name) {
            return damage(grid.descriptor, format!("a second grid is called '{}'", grid.name));
        }
        if grid.shares_tree_of.as_ref().is_some_and(|parent| !known(parent)) {
            return damage(
                grid.descriptor,
                format!("grid '{}' shares the tree of a grid that is not there", grid.name),
            );
        }
        grids.push(grid);
    }
    if cursor.remaining() > 0 {
        return damage(cursor.at(), format!("{} bytes follow the last grid", cursor.remaining()));
    }
    Ok(Layout { format: header.format, library: header.library, metadata, grids })
}
