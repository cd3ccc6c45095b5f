//! What becomes one file: grids over blocks, and metadata.

use glam::IVec3;

use super::Error;
use super::bridge::ffi;
use super::metadata::{Metadata, to_bridge};
use crate::grid::{BLOCK_EDGE, Band, BlockMask, Channel, InsideTile, Lattice, block_order, mask};

/// The least voxel size OpenVDB takes: it holds transforms of a smaller determinant for singular.
const LEAST_VOXEL_SIZE: f64 = 1.45e-5;
/// The largest number that half precision holds.
const LARGEST_HALF: f32 = 65504.0;
/// The edges of a tile in OpenVDB's tree.
const TILE_EDGES: [i32; 3] = [8, 128, 4096];

/// One file: grids that share a lattice, and metadata of the file.
#[derive(Clone, Debug, Default)]
pub struct Frame<'a> {
    /// The grids, in the order in which they stand in the file. Their names differ, their lattice does not.
    pub grids: Vec<Grid<'a>>,
    /// Metadata of the file. No time, host, thread count or path belongs here: the same frame is the same file.
    pub metadata: Metadata,
}

/// One grid of a file.
#[derive(Clone, Debug)]
pub struct Grid<'a> {
    /// The grid's name, such as `surface`, `Cd` or `vel`.
    pub name: &'a str,
    /// Its voxels.
    pub content: Content<'a>,
    /// Whether its values take 16 bits in the file instead of 32.
    pub half: bool,
    /// Further metadata of the grid.
    pub metadata: Metadata,
}

/// The voxels of a grid.
#[derive(Clone, Debug)]
pub enum Content<'a> {
    /// A level set: the band's distances, sign flipped on the way and limited to ± the background, which is what
    /// inactive voxels get by their sign. Tiles become − the background.
    LevelSet(&'a Band),
    /// One number a voxel.
    Floats {
        /// Where and what.
        values: Values<'a, f32>,
        /// Unknown or fog volume.
        class: Class,
    },
    /// Three numbers a voxel, of class unknown.
    Vectors {
        /// Where and what.
        values: Values<'a, [f32; 3]>,
        /// How they follow a transform.
        vector_type: VectorType,
    },
}

/// A channel and where it stands. Inactive voxels of its blocks have its background.
#[derive(Clone, Debug)]
pub struct Values<'a, T> {
    /// The blocks, as many as the channel has.
    pub blocks: Blocks<'a>,
    /// The values.
    pub channel: &'a Channel<T>,
    /// Active tiles, such as those inside a fog volume.
    pub tiles: Tiles<'a, T>,
}

/// Cubes of voxels that have one value each.
#[derive(Clone, Copy, Debug)]
pub struct Tiles<'a, T> {
    /// Where they stand: not where a block does.
    pub places: &'a [InsideTile],
    /// The value of each.
    pub values: &'a [T],
}

impl<T> Default for Tiles<'_, T> {
    fn default() -> Self {
        Self { places: &[], values: &[] }
    }
}

/// Blocks and their active voxels; a [`Band`]'s, or others.
#[derive(Clone, Copy, Debug)]
pub struct Blocks<'a> {
    /// Where the voxels stand.
    pub lattice: Lattice,
    /// The blocks' least corners, sorted by [`block_order`].
    pub origins: &'a [IVec3],
    /// The blocks' active voxels.
    pub active: &'a [BlockMask],
}

impl<'a> From<&'a Band> for Blocks<'a> {
    fn from(band: &'a Band) -> Self {
        Self { lattice: band.lattice, origins: &band.origins, active: &band.active }
    }
}

impl<'a, T> Values<'a, T> {
    /// A channel over a band's blocks and active voxels.
    pub fn over(band: &'a Band, channel: &'a Channel<T>) -> Self {
        Self { blocks: band.into(), channel, tiles: Tiles::default() }
    }
}

/// What a grid of numbers is, other than a level set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Class {
    /// Nothing in particular.
    #[default]
    Unknown,
    /// A density: programs show it as smoke.
    FogVolume,
}

/// How vectors follow when a grid is moved, turned or scaled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VectorType {
    /// They stay as they are: colours, texture coordinates.
    #[default]
    Invariant,
    /// As displacements and velocities do.
    ContravariantRelative,
}

impl<'a> Grid<'a> {
    /// A level set of 32-bit values.
    pub fn level_set(name: &'a str, band: &'a Band) -> Self {
        Self::new(name, Content::LevelSet(band))
    }

    /// A colour: 32-bit vectors that no transform changes, over the band's active voxels. Its name is the channel's.
    pub fn colour(band: &'a Band, channel: &'a Channel<[f32; 3]>) -> Self {
        let values = Values::over(band, channel);
        Self::new(&channel.name, Content::Vectors { values, vector_type: VectorType::Invariant })
    }

    /// A number: 32 bits, of class unknown, over the band's active voxels. Its name is the channel's.
    pub fn scalar(band: &'a Band, channel: &'a Channel<f32>) -> Self {
        let values = Values::over(band, channel);
        Self::new(&channel.name, Content::Floats { values, class: Class::Unknown })
    }

    /// 32-bit values without further metadata.
    pub fn new(name: &'a str, content: Content<'a>) -> Self {
        Self { name, content, half: false, metadata: Metadata::new() }
    }

    pub(super) fn blocks(&self) -> Blocks<'a> {
        match &self.content {
            Content::LevelSet(band) => (*band).into(),
            Content::Floats { values, .. } => values.blocks,
            Content::Vectors { values, .. } => values.blocks,
        }
    }

    fn tiles(&self) -> &'a [InsideTile] {
        match &self.content {
            Content::LevelSet(band) => &band.inside_tiles,
            Content::Floats { values, .. } => values.tiles.places,
            Content::Vectors { values, .. } => values.tiles.places,
        }
    }

    /// Blocks of values, and values that stand outside the blocks.
    fn value_blocks(&self) -> usize {
        match &self.content {
            Content::LevelSet(band) => band.distances.len(),
            Content::Floats { values, .. } => values.channel.values.len(),
            Content::Vectors { values, .. } => values.channel.values.len(),
        }
    }

    /// How many values a channel has in a block; a level set has one for each voxel.
    fn values_of(&self, block: usize) -> Option<usize> {
        match &self.content {
            Content::LevelSet(_) => None,
            Content::Floats { values, .. } => Some(values.channel.values[block].len()),
            Content::Vectors { values, .. } => Some(values.channel.values[block].len()),
        }
    }

    /// What a caller can get wrong, before the bridge relies on it.
    pub(super) fn check(&self) -> Result<(), Error> {
        let blocks = self.blocks();
        let refuse = |problem: String| Err(Error::grid(self.name, problem));
        if self.name.is_empty() || self.name.chars().any(char::is_control) {
            return refuse("a grid's name is text without control characters, and not empty".into());
        }
        if blocks.origins.len() != blocks.active.len() || blocks.origins.len() != self.value_blocks() {
            return refuse(format!(
                "{} origins, {} masks and {} blocks of values do not fit together",
                blocks.origins.len(),
                blocks.active.len(),
                self.value_blocks()
            ));
        }
        for (block, (origin, active)) in blocks.origins.iter().zip(blocks.active).enumerate() {
            let voxels = mask::count(active);
            if let Some(values) = self.values_of(block).filter(|values| *values != voxels) {
                return refuse(format!("block {origin} has {voxels} active voxels and {values} values"));
            }
        }
        let tiles = self.tiles().len();
        if let Some(values) = self.tile_values().filter(|values| *values != tiles) {
            return refuse(format!("{tiles} tiles and {values} values of tiles do not fit together"));
        }
        let size = blocks.lattice.voxel_size.get();
        if size < LEAST_VOXEL_SIZE {
            return refuse(format!("voxels of {size} units are too small for OpenVDB, which needs {LEAST_VOXEL_SIZE}"));
        }
        if let Some(stray) = blocks.origins.iter().find(|origin| misaligned(**origin, BLOCK_EDGE)) {
            return refuse(format!("no block starts at voxel {stray}: it is no multiple of {BLOCK_EDGE}"));
        }
        if let Some(pair) = blocks.origins.windows(2).find(|pair| block_order(pair[0]) >= block_order(pair[1])) {
            return refuse(format!("block {} stands before block {}: sort them, each once", pair[0], pair[1]));
        }
        let stray = |tile: &&InsideTile| !TILE_EDGES.contains(&tile.edge) || misaligned(tile.origin, tile.edge);
        if let Some(tile) = self.tiles().iter().find(stray) {
            return refuse(format!("no tile of {} voxels starts at voxel {}", tile.edge, tile.origin));
        }
        self.check_background().or_else(refuse)
    }

    /// How many tiles have a value of their own; a level set's have the background.
    fn tile_values(&self) -> Option<usize> {
        match &self.content {
            Content::LevelSet(_) => None,
            Content::Floats { values, .. } => Some(values.tiles.values.len()),
            Content::Vectors { values, .. } => Some(values.tiles.values.len()),
        }
    }

    fn check_background(&self) -> Result<(), String> {
        let numbers = match &self.content {
            Content::LevelSet(band) => {
                let background = band.background();
                if !(background.is_finite() && background > 0.0) {
                    return Err(format!("a half-width of {} voxels makes no band", band.half_width));
                }
                vec![background]
            }
            Content::Floats { values, .. } => {
                [&values.channel.background].into_iter().chain(values.tiles.values).copied().collect()
            }
            Content::Vectors { values, .. } => {
                [&values.channel.background].into_iter().chain(values.tiles.values).flatten().copied().collect()
            }
        };
        match numbers.iter().find(|number| !number.is_finite()) {
            Some(number) => Err(format!("its background or a tile is {number}, not a finite number")),
            None if self.half => numbers.iter().try_for_each(|number| check_half(*number)),
            None => Ok(()),
        }
    }

    /// The nodes, leaves and tiles of a grid that was checked, in OpenVDB's hands; with the values of all voxels of its
    /// blocks, or none.
    pub(super) fn in_library(&self, values: &[f32]) -> Result<cxx::SharedPtr<ffi::Grid>, Error> {
        let blocks = self.blocks();
        let metadata = to_bridge(&self.metadata);
        let origins: Vec<i32> = blocks.origins.iter().flat_map(IVec3::to_array).collect();
        let tiles: Vec<i32> =
            self.tiles().iter().flat_map(|tile| [tile.origin.x, tile.origin.y, tile.origin.z, tile.edge]).collect();
        let bridge_blocks = ffi::Blocks {
            origins: &origins,
            masks: blocks.active.as_flattened(),
            values,
            tiles: &tiles,
            tiles_active: !matches!(self.content, Content::LevelSet(_)),
        };
        let (grid_class, vector_type) = self.spelled();
        let head = ffi::Head {
            name: self.name,
            grid_class,
            vector_type,
            voxel_size: blocks.lattice.voxel_size.get(),
            half: self.half,
            metadata: &metadata,
        };
        let made = match &self.content {
            // Tiles lie inside, where the file's distances are negative.
            Content::LevelSet(band) => {
                let inside = vec![-band.background(); band.inside_tiles.len()];
                ffi::float_grid(&head, &bridge_blocks, band.background(), &inside)
            }
            Content::Floats { values, .. } => {
                ffi::float_grid(&head, &bridge_blocks, values.channel.background, values.tiles.values)
            }
            Content::Vectors { values, .. } => {
                let tile_values = values.tiles.values.as_flattened();
                ffi::vector_grid(&head, &bridge_blocks, values.channel.background, tile_values)
            }
        };
        made.map_err(|error| Error::grid(self.name, error.what()))
    }

    /// Class and vector type as OpenVDB spells them.
    fn spelled(&self) -> (&'static str, &'static str) {
        match &self.content {
            Content::LevelSet(_) => ("level set", ""),
            Content::Floats { class: Class::Unknown, .. } => ("unknown", ""),
            Content::Floats { class: Class::FogVolume, .. } => ("fog volume", ""),
            Content::Vectors { vector_type: VectorType::Invariant, .. } => ("unknown", "invariant"),
            Content::Vectors { vector_type: VectorType::ContravariantRelative, .. } => {
                ("unknown", "contravariant relative")
            }
        }
    }
}

/// Half precision turns large values into infinity.
pub(super) fn check_half(number: f32) -> Result<(), String> {
    if number.abs() <= LARGEST_HALF {
        return Ok(());
    }
    Err(format!("{number} is more than 16 bits can hold ({LARGEST_HALF}): keep it in 32 bits"))
}

fn misaligned(origin: IVec3, edge: i32) -> bool {
    origin & IVec3::splat(edge - 1) != IVec3::ZERO
}

impl Frame<'_> {
    /// What grids of one file must have in common, and what not.
    pub(super) fn check(&self) -> Result<(), Error> {
        for (index, grid) in self.grids.iter().enumerate() {
            let earlier = &self.grids[..index];
            if earlier.iter().any(|other| other.name == grid.name) {
                return Err(Error::grid(grid.name, "two grids of one file have this name: rename one"));
            }
            if earlier.iter().any(|other| other.blocks().lattice != grid.blocks().lattice) {
                return Err(Error::grid(grid.name, "its voxels stand elsewhere than those of the file's other grids"));
            }
        }
        Ok(())
    }
}
