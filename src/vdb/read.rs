//! From a file to blocks: any `.vdb`, whoever wrote it.

use std::path::{Path, PathBuf};

use glam::IVec3;

use super::decode::decode;
use super::voxels::{SparseBlocks, Voxels};
use super::walk::{GridLayout, Layout, Transform, walk_bytes};
use super::{Error, Metadata, MetadataValue};
use crate::disk;
use crate::grid::{Band, InsideTile, Lattice, VoxelSize, block_order, block_origin};

/// What was read from a file.
#[derive(Clone, Debug)]
pub struct Contents {
    /// Metadata of the file.
    pub metadata: Metadata,
    /// The grids of numbers and of vectors, in the file's order.
    pub grids: Vec<StoredGrid>,
    /// The grids of other kinds, which were stepped over: name and type.
    pub skipped: Vec<(String, String)>,
}

/// A grid from a file.
#[derive(Clone, Debug)]
pub struct StoredGrid {
    /// Its name.
    pub name: String,
    /// What its values mean.
    pub class: StoredClass,
    /// Where its voxels stand.
    pub transform: Transform,
    /// Its metadata.
    pub metadata: Metadata,
    /// Its voxels.
    pub voxels: Voxels,
}

/// The class of a grid from a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StoredClass {
    /// Nothing in particular.
    Unknown,
    /// Distances; positive inside once they are read.
    LevelSet,
    /// A density.
    FogVolume,
    /// Vectors at the faces of voxels.
    Staggered,
}

impl StoredClass {
    pub(crate) fn of(metadata: &Metadata) -> Self {
        match metadata.get("class") {
            Some(MetadataValue::Text(text)) => match text.as_str() {
                "level set" => Self::LevelSet,
                "fog volume" => Self::FogVolume,
                "staggered" => Self::Staggered,
                _ => Self::Unknown,
            },
            _ => Self::Unknown,
        }
    }
}

impl std::fmt::Display for StoredClass {
    /// As OpenVDB spells it.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Unknown => "unknown",
            Self::LevelSet => "level set",
            Self::FogVolume => "fog volume",
            Self::Staggered => "staggered",
        })
    }
}

/// Reads a file, all of it in Rust: damage is an error, and never a crash.
///
/// # Errors
/// [`Error::Disk`] when it cannot be read; [`Error::Damaged`] and [`Error::Unsupported`] for what is in it.
pub fn read(path: impl AsRef<Path>) -> Result<Contents, Error> {
    let opened = Opened::open(path.as_ref())?;
    let mut contents = Contents { metadata: opened.layout.metadata.clone(), grids: vec![], skipped: vec![] };
    for grid in &opened.layout.grids {
        match opened.grid(grid)? {
            Some(stored) => contents.grids.push(stored),
            None => contents.skipped.push((grid.name.clone(), grid.tree_type.clone())),
        }
    }
    Ok(contents)
}

/// A file in memory that was walked: for whoever wants one of its grids, or to know what is in it first.
pub struct Opened {
    path: PathBuf,
    bytes: Vec<u8>,
    /// What is in it.
    pub layout: Layout,
}

impl Opened {
    /// Reads a file's bytes and walks them.
    ///
    /// # Errors
    /// As [`read`].
    pub fn open(path: &Path) -> Result<Self, Error> {
        let bytes = disk::read(path).map_err(|error| Error::system(path, "read it", error))?;
        Self::from_bytes(bytes, path)
    }

    /// Walks a file's bytes; `path` is for messages.
    ///
    /// # Errors
    /// [`Error::Damaged`] and [`Error::Unsupported`].
    pub fn from_bytes(bytes: Vec<u8>, path: &Path) -> Result<Self, Error> {
        let layout = walk_bytes(&bytes, path)?;
        Ok(Self { path: path.into(), bytes, layout })
    }

    /// The file's size in bytes.
    pub fn size(&self) -> u64 {
        self.bytes.len() as u64
    }

    /// One of the layout's grids, decoded; `None` for a type that is not read.
    ///
    /// # Errors
    /// [`Error::Damaged`] for a buffer that cannot be decompressed, [`Error::Unsupported`] for a codec that OpenVDB never uses.
    pub fn grid(&self, grid: &GridLayout) -> Result<Option<StoredGrid>, Error> {
        Ok(self.voxels(grid)?.map(|voxels| StoredGrid {
            name: grid.name.clone(),
            class: StoredClass::of(&grid.metadata),
            transform: grid.transform.clone(),
            metadata: grid.metadata.clone(),
            voxels,
        }))
    }

    /// A grid's voxels; `None` for a type that is not read.
    pub(super) fn voxels(&self, grid: &GridLayout) -> Result<Option<Voxels>, Error> {
        let flip = StoredClass::of(&grid.metadata) == StoredClass::LevelSet;
        let (owner, bytes) = (self.layout.owner(grid), &self.bytes);
        let voxels = match owner.tree_type.as_str() {
            "Tree_float_5_4_3" => decode::<f32, f32, 1>(bytes, owner, flip).map(Voxels::Floats),
            "Tree_double_5_4_3" => decode::<f64, f32, 1>(bytes, owner, flip).map(Voxels::Floats),
            "Tree_vec3s_5_4_3" => decode::<f32, [f32; 3], 3>(bytes, owner, false).map(Voxels::Vectors),
            "Tree_vec3d_5_4_3" => decode::<f64, [f32; 3], 3>(bytes, owner, false).map(Voxels::Vectors),
            _ => return Ok(None),
        };
        voxels.map(Some).map_err(|failure| failure.of_grid(&grid.name).in_file(&self.path))
    }
}

impl StoredGrid {
    /// A level set as a band, where its voxels stand as a [`Lattice`] has them: cubes along the axes, a voxel's centre
    /// at the world's origin.
    ///
    /// # Errors
    /// What keeps it from being one.
    pub fn to_band(&self) -> Result<Band, String> {
        let (StoredClass::LevelSet, Voxels::Floats(blocks)) = (self.class, &self.voxels) else {
            return Err(format!("grid '{}' is no level set", self.name));
        };
        let size = self.transform.uniform_voxel_size().and_then(VoxelSize::new);
        let Some(voxel_size) = size else {
            return Err(format!("the voxels of grid '{}' are no cubes along the axes", self.name));
        };
        let origin = self.transform.world(glam::DVec3::ZERO).unwrap_or(glam::DVec3::NAN) / voxel_size.get();
        let shift = origin.round();
        if !((origin - shift).abs().max_element() <= 1e-6 && shift.abs().max_element() < f64::from(1 << 24)) {
            return Err(format!("the world's origin is no voxel centre of grid '{}'", self.name));
        }
        let shift = shift.as_ivec3();
        if block_origin(shift) != shift {
            return Err(format!("grid '{}' is shifted by {shift} voxels, which is no number of blocks", self.name));
        }
        let half_width = -f64::from(blocks.background) / voxel_size.get();
        if !(half_width.is_finite() && half_width > 0.0) {
            let outside = -blocks.background;
            return Err(format!("the background of grid '{}' is {outside}, not the half-width of a band", self.name));
        }
        Ok(band_of(blocks, shift, voxel_size, half_width as f32))
    }
}

/// A level set's blocks, shifted by voxels, as a band.
pub(super) fn band_of(blocks: &SparseBlocks<f32>, shift: IVec3, voxel_size: VoxelSize, half_width: f32) -> Band {
    let inside = blocks.tiles.iter().filter(|tile| tile.value > 0.0);
    let inside_tiles = inside.map(|tile| InsideTile { origin: tile.origin + shift, edge: tile.edge }).collect();
    let mut band = Band {
        lattice: Lattice { voxel_size },
        half_width,
        origins: blocks.origins.iter().map(|origin| *origin + shift).collect(),
        distances: blocks.values.clone(),
        active: blocks.active.clone(),
        inside_tiles,
    };
    sort_blocks(&mut band);
    band
}

/// Sorts a band's blocks and tiles: a shift can carry them across the borders of the tree's nodes.
fn sort_blocks(band: &mut Band) {
    band.inside_tiles.sort_by_key(|tile| block_order(tile.origin));
    if band.origins.is_sorted_by_key(|origin| block_order(*origin)) {
        return;
    }
    let mut order: Vec<usize> = (0..band.origins.len()).collect();
    order.sort_by_key(|block| block_order(band.origins[*block]));
    band.origins = order.iter().map(|block| band.origins[*block]).collect();
    band.distances = order.iter().map(|block| band.distances[*block]).collect();
    band.active = order.iter().map(|block| band.active[*block]).collect();
}
