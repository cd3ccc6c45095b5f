//! Colours of a volume of voxels, everywhere in space.
//!
//! Positions here are in voxels: the centre of voxel (i, j, k) is at (i, j, k), and its cube reaches half a voxel
//! further. The volume is the union of the cubes of all active voxels. In it colours are sampled trilinearly; outside
//! of it [`Outside`] says how they go on.

mod bound;
mod clusters;
mod group;
mod nearest;
mod potential;
mod series;
mod tree;

use glam::{DVec3, IVec3};
use rustc_hash::FxHashMap;

use super::{Attribute, LinearRgb, Sampler};
use crate::field::{Aabb, BATCH, Points};
use crate::grid::{BLOCK_VOXELS, BlockMask, block_origin, is_active, voxel_offset};

use clusters::Clusters;
use nearest::{Nearest, foot};
use potential::Potential;
pub use potential::{POWERS, RELATIVE_ERROR};
use tree::Tree;

/// How the colours of a volume go on outside of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outside {
    /// With the colour of the nearest point of the volume.
    Foot,
    /// With the mean of all voxels, weighted by 1/dᵖ, d the distance to a voxel's centre (STB, eq. 4): p, one of
    /// [`POWERS`].
    Potential(u32),
}

/// Voxels with colours: blocks, and where they stand.
#[derive(Clone, Debug)]
pub struct ColourBlocks {
    /// A voxel's edge, world units.
    pub voxel_size: f64,
    /// Where the centre of voxel (0, 0, 0) is.
    pub origin: DVec3,
    /// The blocks' least corners, each once.
    pub origins: Vec<IVec3>,
    /// The colours of each block, finite where they are active.
    pub values: Vec<[LinearRgb; BLOCK_VOXELS]>,
    /// The active voxels of each block.
    pub active: Vec<BlockMask>,
}

/// The colours of a volume of voxels.
pub struct VoxelColours {
    volume: Volume,
    tree: Tree,
    beyond: Beyond,
    voxel_size: f64,
    origin: DVec3,
}

/// What is needed outside of the volume.
enum Beyond {
    Foot,
    Potential(u32, Clusters),
}

impl VoxelColours {
    /// Colours of voxels; `None` where none is active.
    pub fn new(blocks: ColourBlocks, outside: Outside) -> Option<Self> {
        let ColourBlocks { voxel_size, origin, origins, values, active } = blocks;
        let places = origins.iter().enumerate().map(|(block, origin)| (*origin, block as u32)).collect();
        let volume = Volume { origins, values, active, places };
        let tree = Tree::new(&volume)?;
        let beyond = match outside {
            Outside::Foot => Beyond::Foot,
            Outside::Potential(power) => Beyond::Potential(power, Clusters::new(&volume, &tree)),
        };
        Some(Self { volume, tree, beyond, voxel_size, origin })
    }

    /// Memory that it takes, about, in bytes.
    pub fn memory(&self) -> u64 {
        let voxels = self.volume.active.as_flattened().iter().map(|word| u64::from(word.count_ones())).sum();
        let outside = match self.beyond {
            Beyond::Foot => Outside::Foot,
            Beyond::Potential(power, _) => Outside::Potential(power),
        };
        Self::bytes(self.volume.origins.len() as u64, voxels, outside)
    }

    /// Memory that so many blocks with so many active voxels take at most, in bytes.
    pub fn bytes(blocks: u64, voxels: u64, outside: Outside) -> u64 {
        const BYTES_A_BLOCK: u64 = (BLOCK_VOXELS * size_of::<LinearRgb>() + size_of::<BlockMask>() + 64) as u64;
        // A cube of 4³ voxels holds at least one; above there is a node a block, and fewer than that above these.
        let cubes = voxels.min(blocks.saturating_mul(tree::CUBES_A_BLOCK));
        let nodes = cubes.saturating_add(blocks.saturating_mul(2));
        let bytes_a_node = match outside {
            Outside::Foot => tree::BYTES_A_NODE,
            Outside::Potential(_) => tree::BYTES_A_NODE + clusters::BYTES_A_NODE,
        };
        blocks.saturating_mul(BYTES_A_BLOCK).saturating_add(nodes.saturating_mul(bytes_a_node))
    }
}

/// Blocks, found by their place.
struct Volume {
    origins: Vec<IVec3>,
    values: Vec<[LinearRgb; BLOCK_VOXELS]>,
    active: Vec<BlockMask>,
    places: FxHashMap<IVec3, u32>,
}

impl Volume {
    /// The colour of a voxel, where it is active.
    fn colour(&self, voxel: IVec3) -> Option<LinearRgb> {
        let block = *self.places.get(&block_origin(voxel))? as usize;
        let offset = voxel_offset(voxel);
        is_active(&self.active[block], offset).then(|| self.values[block][offset])
    }

    /// The trilinear mean around a point of the volume; inactive corners are left out. The voxel that the point is in
    /// is active and among the corners, so an eighth of the weight is always there.
    fn trilinear(&self, at: DVec3) -> LinearRgb {
        let floor = at.floor();
        let (corner, share) = (floor.as_ivec3(), (at - floor).as_vec3());
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for i in 0..8 {
            let step = IVec3::new(i >> 2, i >> 1 & 1, i & 1);
            let side = |axis: usize| if step[axis] == 1 { share[axis] } else { 1.0 - share[axis] };
            let weight = side(0) * side(1) * side(2);
            if let Some(colour) = self.colour(corner.wrapping_add(step)) {
                (0..3).for_each(|channel| sum[channel] += weight * colour[channel]);
                total += weight;
            }
        }
        sum.map(|sum: f32| sum / total)
    }
}

impl Attribute<3> for VoxelColours {
    fn sampler(&self) -> Box<dyn Sampler<3> + '_> {
        let VoxelColours { volume, tree, .. } = self;
        let finder = match &self.beyond {
            Beyond::Foot => Finder::Foot(Nearest::new(volume, tree)),
            Beyond::Potential(power, clusters) => Finder::Potential(Potential::new(volume, tree, clusters, *power)),
        };
        Box::new(VoxelSampler { colours: self, finder, far: Vec::with_capacity(BATCH) })
    }
}

/// What finds colours outside of the volume.
enum Finder<'a> {
    Foot(Nearest<'a>),
    Potential(Potential<'a>),
}

struct VoxelSampler<'a> {
    colours: &'a VoxelColours,
    finder: Finder<'a>,
    /// Points outside of the volume, and their places in the batch.
    far: Vec<(DVec3, usize)>,
}

impl Sampler<3> for VoxelSampler<'_> {
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [LinearRgb; BATCH]) {
        let VoxelColours { volume, voxel_size, origin, .. } = self.colours;
        self.far.clear();
        for (i, out) in out.iter_mut().enumerate().take(points.len) {
            let at = (points.position(i) - origin) / *voxel_size;
            if volume.colour(at.round().as_ivec3()).is_some() {
                *out = volume.trilinear(at);
            } else {
                self.far.push((at, i));
            }
        }
        match &mut self.finder {
            Finder::Foot(nearest) => nearest.find(&mut self.far, &mut |at, place, voxel| {
                out[place] = volume.trilinear(foot(at, voxel, voxel));
            }),
            Finder::Potential(potential) => potential.sample(&mut self.far, out),
        }
    }
}

#[cfg(test)]
mod tests;
