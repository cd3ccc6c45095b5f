//! Batches of points and what is computed at them, laid out for vector instructions.

use glam::{DVec3, Vec3};

use super::Aabb;
use super::part::Sample;
use crate::grid::{BLOCK_EDGE, BLOCK_VOXELS};

/// The most points evaluated in one call.
pub const BATCH: usize = 512;

/// Up to [`BATCH`] positions: an `f64` origin and `f32` offsets from it, world units. Keep offsets small (a few
/// blocks), so that positions far from the world's origin keep their accuracy.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct Points {
    /// Offsets along x; entries past `len` are finite and of no meaning.
    pub x: [f32; BATCH],
    /// Offsets along y.
    pub y: [f32; BATCH],
    /// Offsets along z.
    pub z: [f32; BATCH],
    /// What the offsets are from, in the world.
    pub origin: DVec3,
    /// How many points there are.
    pub len: usize,
}

impl Points {
    /// No points, around an origin.
    pub fn new(origin: DVec3) -> Self {
        Self { x: [0.0; BATCH], y: [0.0; BATCH], z: [0.0; BATCH], origin, len: 0 }
    }

    /// Some positions, at least one and no more than a batch holds, around the first.
    pub fn of_positions(positions: &[DVec3]) -> Self {
        let mut points = Self::new(positions[0]);
        positions.iter().for_each(|position| points.push((*position - positions[0]).as_vec3()));
        points
    }

    /// The 512 voxel centres of a leaf block, in the block's own order, around the block's middle.
    pub fn of_block(origin: glam::IVec3, lattice: &crate::grid::Lattice) -> Self {
        let mut points = Self::new(Self::middle_of_block(origin, lattice));
        let offsets = Self::offsets_in_block(lattice);
        for i in 0..BLOCK_VOXELS {
            points.x[i] = offsets[i >> 6];
            points.y[i] = offsets[(i >> 3) & 7];
            points.z[i] = offsets[i & 7];
        }
        points.len = BLOCK_VOXELS;
        points
    }

    /// The middle of a block's voxel centres, world units: where [`Self::of_block`] has its origin. The offsets from
    /// there are those of any block.
    pub fn middle_of_block(origin: glam::IVec3, lattice: &crate::grid::Lattice) -> DVec3 {
        (origin.as_dvec3() + f64::from(BLOCK_EDGE - 1) / 2.0) * lattice.voxel_size.get()
    }

    /// The offsets of a block's voxel centres from its middle, along any axis.
    pub fn offsets_in_block(lattice: &crate::grid::Lattice) -> [f32; BLOCK_EDGE as usize] {
        let half = f64::from(BLOCK_EDGE - 1) / 2.0;
        std::array::from_fn(|i| ((i as f64 - half) * lattice.voxel_size.get()) as f32)
    }

    /// Appends a point given by its offset from the origin. Panics when full.
    pub fn push(&mut self, offset: Vec3) {
        self.x[self.len] = offset.x;
        self.y[self.len] = offset.y;
        self.z[self.len] = offset.z;
        self.len += 1;
    }

    /// The box of all points; `None` of none.
    pub fn bounding_box(&self) -> Option<Aabb> {
        if self.len == 0 {
            return None;
        }
        let [x, y, z] = [&self.x, &self.y, &self.z].map(|values| range(&values[..self.len]).map(f64::from));
        let corner = |i: usize| DVec3::new(x[i], y[i], z[i]) + self.origin;
        Some(Aabb::new(corner(0), corner(1)))
    }

    /// The offset of a point from the origin.
    pub fn offset(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    /// The world position of a point.
    pub fn position(&self, i: usize) -> DVec3 {
        self.origin + self.offset(i).as_dvec3()
    }
}

/// The least and the greatest of some numbers; ±∞ of none.
#[multiversion::multiversion(targets = "simd")]
fn range(values: &[f32]) -> [f32; 2] {
    const LANES: usize = 32;
    let (mut least, mut greatest) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
    let Some(&first) = values.first() else { return [least[0], greatest[0]] };
    let (rows, rest) = values.as_chunks::<LANES>();
    // The first again in the place of those that are missing.
    let mut last = [first; LANES];
    last[..rest.len()].copy_from_slice(rest);
    for row in rows.iter().chain([&last]) {
        for i in 0..LANES {
            least[i] = lesser(row[i], least[i]);
            greatest[i] = greater(row[i], greatest[i]);
        }
    }
    for half in [16, 8, 4, 2, 1] {
        for i in 0..half {
            least[i] = lesser(least[i], least[half + i]);
            greatest[i] = greater(greatest[i], greatest[half + i]);
        }
    }
    [least[0], greatest[0]]
}

// One vector instruction each; what is no number is passed over where it comes first.

#[inline(always)]
pub(crate) fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
pub(crate) fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Values and gradients at a batch of points.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct Gradients {
    /// F.
    pub value: [f32; BATCH],
    /// ∂F/∂x.
    pub dx: [f32; BATCH],
    /// ∂F/∂y.
    pub dy: [f32; BATCH],
    /// ∂F/∂z.
    pub dz: [f32; BATCH],
}

impl Gradients {
    /// All zeros.
    pub fn new() -> Self {
        Self { value: [0.0; BATCH], dx: [0.0; BATCH], dy: [0.0; BATCH], dz: [0.0; BATCH] }
    }

    /// The gradient at a point.
    pub fn gradient(&self, i: usize) -> Vec3 {
        Vec3::new(self.dx[i], self.dy[i], self.dz[i])
    }

    /// Value and gradient at a point.
    pub(crate) fn set(&mut self, i: usize, (value, gradient): Sample) {
        let gradient = gradient.as_vec3();
        self.value[i] = value as f32;
        (self.dx[i], self.dy[i], self.dz[i]) = (gradient.x, gradient.y, gradient.z);
    }
}

impl Default for Gradients {
    fn default() -> Self {
        Self::new()
    }
}
