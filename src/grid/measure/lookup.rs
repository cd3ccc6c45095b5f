//! Finding blocks and tiles by position.

use glam::IVec3;
use rustc_hash::FxHashMap;

use crate::grid::{BLOCK_EDGE, Band, block_origin, node_origin, voxel_offset};

/// The edges of tiles, as OpenVDB's tree has them.
const TILE_EDGES: [i32; 3] = [BLOCK_EDGE, 128, 4096];

/// What a band holds at a voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Nothing: outside.
    Outside,
    /// The inside tile of this index.
    Tile(usize),
    /// A voxel of a block.
    Voxel {
        /// The block's index.
        block: usize,
        /// The voxel's place in it.
        offset: usize,
    },
}

/// Tables that find blocks and tiles. They are asked, never walked, so their order cannot reach a result.
pub struct Lookup<'a> {
    band: &'a Band,
    blocks: FxHashMap<IVec3, usize>,
    tiles: FxHashMap<(IVec3, i32), usize>,
}

impl<'a> Lookup<'a> {
    /// Those of a band.
    pub fn new(band: &'a Band) -> Self {
        let blocks = band.origins.iter().enumerate().map(|(index, &origin)| (origin, index)).collect();
        let tile = |(index, tile): (usize, &crate::grid::InsideTile)| ((tile.origin, tile.edge), index);
        Self { band, blocks, tiles: band.inside_tiles.iter().enumerate().map(tile).collect() }
    }

    /// What stands at a voxel.
    pub fn at(&self, voxel: IVec3) -> Place {
        if let Some(&block) = self.blocks.get(&block_origin(voxel)) {
            return Place::Voxel { block, offset: voxel_offset(voxel) };
        }
        let tile = |edge: i32| self.tiles.get(&(node_origin(voxel, edge), edge));
        TILE_EDGES.into_iter().find_map(tile).map_or(Place::Outside, |&index| Place::Tile(index))
    }

    /// The surroundings of a block.
    pub fn around(&self, block: usize) -> Surroundings<'_> {
        let origin = self.band.origins[block];
        let places = std::array::from_fn(|at| {
            let step = IVec3::new((at / 9) as i32, (at / 3 % 3) as i32, (at % 3) as i32) - 1;
            // Past the last index lies nothing; wrapping would find the other end of the world.
            let neighbour = origin.checked_add(step * BLOCK_EDGE);
            neighbour.map_or(Place::Outside, |neighbour| self.at(neighbour))
        });
        Surroundings { band: self.band, places }
    }
}

/// A block and its 26 neighbours.
pub struct Surroundings<'a> {
    band: &'a Band,
    places: [Place; 27],
}

impl Surroundings<'_> {
    /// What stands at the least voxel of a neighbour, so many blocks on.
    pub fn neighbour(&self, step: IVec3) -> Place {
        self.places[((step.x + 1) * 9 + (step.y + 1) * 3 + step.z + 1) as usize]
    }

    /// What stands at a voxel, given from the block's origin: −8 to 15 on each axis.
    pub fn at(&self, local: IVec3) -> Place {
        match self.neighbour((local + BLOCK_EDGE) / BLOCK_EDGE - 1) {
            Place::Voxel { block, .. } => Place::Voxel { block, offset: voxel_offset(local) },
            uniform => uniform,
        }
    }

    /// The distance there, ± the background away from all blocks.
    pub fn value(&self, local: IVec3) -> f32 {
        match self.at(local) {
            Place::Outside => -self.band.background(),
            Place::Tile(_) => self.band.background(),
            Place::Voxel { block, offset } => self.band.distances[block][offset],
        }
    }
}

/// The index position of a block's voxel.
pub fn voxel_of(origin: IVec3, offset: usize) -> IVec3 {
    origin + local_of(offset)
}

/// A voxel's place in its block, 0 to 7 on each axis.
pub fn local_of(offset: usize) -> IVec3 {
    IVec3::new((offset / 64) as i32, (offset / 8 % 8) as i32, (offset % 8) as i32)
}
