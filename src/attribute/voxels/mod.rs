//! Values of a volume of voxels, colours or scalars, everywhere in space.
//!
//! Positions here are in voxels: the centre of voxel (i, j, k) is at (i, j, k), and its cube reaches half a voxel
//! further. The volume is the union of the cubes of all active voxels. In it values are sampled trilinearly; outside
//! of it [`Outside`] says how they go on.

mod nearest;
mod potential;
mod tree;

use glam::{DVec3, IVec3};
use rustc_hash::FxHashMap;

use super::{Attribute, Sampler, around};
use crate::field::{Aabb, BATCH, Interval, Points};
use crate::grid::{BLOCK_VOXELS, BlockMask, block_origin, is_active, voxel_offset};

use potential::Potential;
pub use potential::{POWERS, RELATIVE_ERROR};
use tree::Tree;

/// How the values of a volume go on outside of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outside {
    /// With the value of the nearest point of the volume.
    Foot,
    /// With the mean of all voxels, weighted by 1/dᵖ, d the distance to a voxel's centre (STB, eq. 4): p, one of
    /// [`POWERS`].
    Potential(u32),
}

/// Voxels with `N` numbers each: blocks, and where they stand.
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
    tree: Tree<N>,
    voxel_size: f64,
    origin: DVec3,
    outside: Outside,
}

impl<const N: usize> VoxelValues<N> {
    /// Values of voxels; `None` where none is active.
    pub fn new(blocks: ValueBlocks<N>, outside: Outside) -> Option<Self> {
        let ValueBlocks { voxel_size, origin, origins, values, active } = blocks;
        let places = origins.iter().enumerate().map(|(block, origin)| (*origin, block as u32)).collect();
        let volume = Volume { origins, values, active, places };
        let tree = Tree::new(&volume)?;
        Some(Self { volume, tree, voxel_size, origin, outside })
    }

    /// Memory that it takes, about, in bytes.
    pub fn memory(&self) -> u64 {
        Self::bytes(self.volume.origins.len() as u64, self.tree.nodes[0].count as u64)
    }

    /// Memory that so many blocks with so many active voxels take at most, in bytes.
    pub fn bytes(blocks: u64, voxels: u64) -> u64 {
        let bytes_a_block = (BLOCK_VOXELS * size_of::<[f32; N]>() + size_of::<BlockMask>() + 64) as u64;
        // A cube of 2³ voxels holds at least one, and at most 64 are in a block; the nodes above it are fewer by far.
        let cubes = voxels.min(blocks.saturating_mul(64));
        let nodes = cubes.saturating_add(cubes / 4).saturating_mul(size_of::<tree::Node<N>>() as u64);
        blocks.saturating_mul(bytes_a_block).saturating_add(nodes)
    }
}

/// Blocks, found by their place.
struct Volume<const N: usize> {
    origins: Vec<IVec3>,
    values: Vec<[[f32; N]; BLOCK_VOXELS]>,
    active: Vec<BlockMask>,
    places: FxHashMap<IVec3, u32>,
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
        let potential = match self.outside {
            Outside::Foot => None,
            Outside::Potential(power) => Some(Potential::new(&self.volume, &self.tree, power)),
        };
        Box::new(VoxelSampler { values: self, potential, far: Vec::with_capacity(BATCH) })
    }
}

struct VoxelSampler<'a, const N: usize> {
    values: &'a VoxelValues<N>,
    potential: Option<Potential<'a, N>>,
    /// Points outside of the volume, and their places in the batch.
    far: Vec<(DVec3, usize)>,
}

impl<const N: usize> Sampler<N> for VoxelSampler<'_, N> {
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [[f32; N]; BATCH]) {
        let VoxelValues { volume, tree, voxel_size, origin, .. } = self.values;
        self.far.clear();
        let mut near = None;
        for (i, out) in out.iter_mut().enumerate().take(points.len) {
            let at = (points.position(i) - origin) / *voxel_size;
            if volume.value(at.round().as_ivec3()).is_some() {
                *out = volume.trilinear(at);
            } else if self.potential.is_some() {
                self.far.push((at, i));
            } else {
                let voxel = tree.nearest(volume, at, near);
                near = Some(voxel);
                let half = DVec3::splat(0.5);
                *out = volume.trilinear(at.clamp(voxel.as_dvec3() - half, voxel.as_dvec3() + half));
            }
        }
        if let Some(potential) = &mut self.potential {
            potential.sample(&mut self.far, out);
        }
    }

    /// Of all voxels: means of theirs, but for the error of those of all.
    fn bounds(&mut self, _region: &Aabb) -> [Interval; N] {
        let share = if self.potential.is_some() { RELATIVE_ERROR / (1.0 - RELATIVE_ERROR) } else { 0.0 };
        let grown = |Interval { lo, hi }| Interval::new(lo - share * (hi - lo), hi + share * (hi - lo));
        around(self.values.tree.range.into_iter()).map(grown)
    }
}

#[cfg(test)]
mod tests;
