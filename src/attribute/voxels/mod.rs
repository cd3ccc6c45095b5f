//! Values of a volume of voxels, colours or scalars, everywhere in space.
//!
//! Positions here are in voxels: the centre of voxel (i, j, k) is at (i, j, k), and its cube reaches half a voxel
//! further. The volume is the union of the cubes of all active voxels. In it values are sampled trilinearly; outside
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

use super::{Attribute, LinearRgb, Sampler, around};
use crate::field::{Aabb, BATCH, Interval, Points};
use crate::grid::{BLOCK_VOXELS, BlockMask, block_origin, is_active, mask, voxel_offset};

use clusters::Clusters;
use nearest::{Nearest, foot};
use potential::Potential;
pub use potential::{POWERS, RELATIVE_ERROR};
use tree::Tree;

/// How the values of a volume go on outside of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outside {
    /// With the value of the nearest point of the volume.
    Foot,
    /// With the mean of all voxels, weighted by 1/dᵖ, d the distance to a voxel's centre (STB, eq. 4).
    Potential(Power),
}

/// The power p of a distance: one of [`POWERS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Power(u32);

impl Power {
    /// `None` for a number that is none of [`POWERS`].
    pub fn new(power: u32) -> Option<Self> {
        POWERS.contains(&power).then_some(Self(power))
    }
}

/// Voxels with `N` numbers each, 3 at most: blocks, and where they stand.
#[derive(Clone, Debug)]
pub struct ValueBlocks<const N: usize> {
    /// A voxel's edge, world units.
    pub voxel_size: f64,
    /// Where the centre of voxel (0, 0, 0) is.
    pub origin: DVec3,
    /// The blocks' least corners, each once.
    pub origins: Vec<IVec3>,
    /// The values of each block, finite where they are active.
    pub values: Vec<[[f32; N]; BLOCK_VOXELS]>,
    /// The active voxels of each block.
    pub active: Vec<BlockMask>,
}

/// The values of a volume of voxels.
pub struct VoxelValues<const N: usize> {
    volume: Volume<N>,
    tree: Tree,
    beyond: Beyond,
    /// Of all active voxels.
    range: [Interval; N],
    voxel_size: f64,
    origin: DVec3,
}

/// What is needed outside of the volume.
enum Beyond {
    Foot,
    Potential(Power, Clusters),
}

impl<const N: usize> VoxelValues<N> {
    /// Values of voxels; `None` where none is active.
    pub fn new(blocks: ValueBlocks<N>, outside: Outside) -> Option<Self> {
        const { assert!(N <= 3, "sums are of three numbers") };
        let ValueBlocks { voxel_size, origin, origins, values, active } = blocks;
        let places = origins.iter().enumerate().map(|(block, origin)| (*origin, block as u32)).collect();
        let volume = Volume { origins, values, active, places };
        let tree = Tree::new(&volume)?;
        let beyond = match outside {
            Outside::Foot => Beyond::Foot,
            Outside::Potential(power) => Beyond::Potential(power, Clusters::new(&volume, &tree)),
        };
        let blocks = volume.active.iter().zip(&volume.values);
        let range = around(blocks.flat_map(|(active, values)| mask::places(active).map(move |place| values[place])));
        Some(Self { volume, tree, beyond, range, voxel_size, origin })
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
        let bytes_a_block = (BLOCK_VOXELS * size_of::<[f32; N]>() + size_of::<BlockMask>() + 64) as u64;
        // A cube of 4³ voxels holds at least one; above there is a node a block, and fewer than that above these.
        let cubes = voxels.min(blocks.saturating_mul(tree::CUBES_A_BLOCK));
        let nodes = cubes.saturating_add(blocks.saturating_mul(2));
        let bytes_a_node = match outside {
            Outside::Foot => tree::BYTES_A_NODE,
            Outside::Potential(_) => tree::BYTES_A_NODE + clusters::BYTES_A_NODE,
        };
        blocks.saturating_mul(bytes_a_block).saturating_add(nodes.saturating_mul(bytes_a_node))
    }
}

/// Blocks, found by their place.
struct Volume<const N: usize> {
    origins: Vec<IVec3>,
    values: Vec<[[f32; N]; BLOCK_VOXELS]>,
    active: Vec<BlockMask>,
    places: FxHashMap<IVec3, u32>,
}

/// The numbers that are summed for a value: the rest is 0.
fn three<const N: usize>(value: [f32; N]) -> LinearRgb {
    std::array::from_fn(|number| value.get(number).copied().unwrap_or(0.0))
}

impl<const N: usize> Volume<N> {
    /// The value of a voxel, where it is active.
    fn value(&self, voxel: IVec3) -> Option<[f32; N]> {
        let block = *self.places.get(&block_origin(voxel))? as usize;
        let offset = voxel_offset(voxel);
        is_active(&self.active[block], offset).then(|| self.values[block][offset])
    }

    /// The trilinear mean around a point of the volume; inactive corners are left out. The voxel that the point is in
    /// is active and among the corners, so an eighth of the weight is always there.
    fn trilinear(&self, at: DVec3) -> [f32; N] {
        let floor = at.floor();
        let (corner, share) = (floor.as_ivec3(), (at - floor).as_vec3());
        let (mut sum, mut total) = ([0.0; N], 0.0);
        for i in 0..8 {
            let step = IVec3::new(i >> 2, i >> 1 & 1, i & 1);
            let side = |axis: usize| if step[axis] == 1 { share[axis] } else { 1.0 - share[axis] };
            let weight = side(0) * side(1) * side(2);
            if let Some(value) = self.value(corner.wrapping_add(step)) {
                (0..N).for_each(|number| sum[number] += weight * value[number]);
                total += weight;
            }
        }
        sum.map(|sum: f32| sum / total)
    }
}

impl<const N: usize> Attribute<N> for VoxelValues<N> {
    fn sampler(&self) -> Box<dyn Sampler<N> + '_> {
        let VoxelValues { volume, tree, .. } = self;
        let finder = match &self.beyond {
            Beyond::Foot => Finder::Foot(Nearest::new(volume, tree)),
            Beyond::Potential(power, clusters) => Finder::Potential(Potential::new(volume, tree, clusters, power.0)),
        };
        Box::new(VoxelSampler { values: self, finder, far: Vec::with_capacity(BATCH) })
    }
}

/// What finds values outside of the volume.
enum Finder<'a, const N: usize> {
    Foot(Nearest<'a, N>),
    Potential(Potential<'a, N>),
}

struct VoxelSampler<'a, const N: usize> {
    values: &'a VoxelValues<N>,
    finder: Finder<'a, N>,
    /// Points outside of the volume, and their places in the batch.
    far: Vec<(DVec3, usize)>,
}

impl<const N: usize> Sampler<N> for VoxelSampler<'_, N> {
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [[f32; N]; BATCH]) {
        let VoxelValues { volume, voxel_size, origin, .. } = self.values;
        self.far.clear();
        for (i, out) in out.iter_mut().enumerate().take(points.len) {
            let at = (points.position(i) - origin) / *voxel_size;
            if volume.value(at.round().as_ivec3()).is_some() {
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

    /// Of all voxels: means of theirs, but for the error of those of all.
    fn bounds(&mut self, _region: &Aabb) -> [Interval; N] {
        let share = match self.finder {
            Finder::Foot(_) => 0.0,
            Finder::Potential(_) => RELATIVE_ERROR / (1.0 - RELATIVE_ERROR),
        };
        self.values.range.map(|Interval { lo, hi }| Interval::new(lo - share * (hi - lo), hi + share * (hi - lo)))
    }
}

#[cfg(test)]
mod tests;
