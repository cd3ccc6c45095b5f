//! Batches of points and what is computed at them, laid out for vector instructions.

use glam::{DVec3, Vec3};

use super::Aabb;
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

    /// The 512 voxel centres of a leaf block, in the block's own order, around the block's middle.
    pub fn of_block(origin: glam::IVec3, lattice: &crate::grid::Lattice) -> Self {
        let edge = lattice.voxel_size.get();
        let half = f64::from(BLOCK_EDGE - 1) / 2.0;
        let mut points = Self::new(Self::middle_of_block(origin, lattice));
        let offset = |i: usize| ((i as f64 - half) * edge) as f32;
        for i in 0..BLOCK_VOXELS {
            points.x[i] = offset(i >> 6);
            points.y[i] = offset((i >> 3) & 7);
            points.z[i] = offset(i & 7);
        }
        points.len = BLOCK_VOXELS;
        points
    }

    /// The middle of a block's voxel centres, world units: where [`Self::of_block`] has its origin. The offsets from
    /// there are those of any block.
    pub fn middle_of_block(origin: glam::IVec3, lattice: &crate::grid::Lattice) -> DVec3 {
        (origin.as_dvec3() + f64::from(BLOCK_EDGE - 1) / 2.0) * lattice.voxel_size.get()
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
        let side = |values: &[f32; BATCH], choose: fn(f32, f32) -> f32| {
            values[..self.len].iter().copied().reduce(choose).map(f64::from)
        };
        let corner = |choose| {
            Some(DVec3::new(side(&self.x, choose)?, side(&self.y, choose)?, side(&self.z, choose)?) + self.origin)
        };
        Some(Aabb::new(corner(f32::min)?, corner(f32::max)?))
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
}

impl Default for Gradients {
    fn default() -> Self {
        Self::new()
    }
}
