//! What is known of a block: while its neighbours may still offer nearer feet, and when it is finished.

use glam::{DVec3, IVec3, Vec3};
use multiversion::multiversion;

use crate::{
    field::{Aabb, Points},
    grid::{BLOCK_EDGE, BLOCK_VOXELS, BlockMask, Lattice, mask},
};

use super::descent::Scope;

/// Room around a block, in voxels beyond the half width, in which its feet are sought.
pub const ROOM: f64 = 1.0;

/// A finished block, as visitors see it. Offsets of all points are from the same origin.
pub struct MeasuredBlock<'a> {
    /// The block's least corner.
    pub origin: IVec3,
    /// Where the voxels stand.
    pub lattice: Lattice,
    /// A box that holds all voxel centres and feet.
    pub region: Aabb,
    /// The voxel centres.
    pub points: &'a Points,
    /// Signed distances, world units, positive inside, clamped to ± the background.
    pub distances: &'a [f32; BLOCK_VOXELS],
    /// Voxels nearer to the surface than the background.
    pub active: &'a BlockMask,
    /// The closest surface point of each active voxel; an inactive voxel's own centre.
    pub feet: &'a Points,
    /// Gradients of the distance: unit vectors pointing inward, x, y and z; zero at inactive voxels.
    pub normals: &'a [[f32; BLOCK_VOXELS]; 3],
}

/// What a block turned out to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It holds active voxels.
    Band,
    /// No active voxel, all outside.
    Outside,
    /// No active voxel, all inside.
    Inside,
}

/// A measured block that its neighbours may still improve.
#[derive(Clone)]
pub struct Staged {
    /// Its least corner.
    pub origin: IVec3,
    /// Signed distances, not clamped; ± infinity where no foot was found.
    pub distances: [f32; BLOCK_VOXELS],
    /// Gradients of the distance, so that `voxel − distance · normal` is the foot; zero where there is none.
    pub normals: [[f32; BLOCK_VOXELS]; 3],
    /// Voxels beside features thinner than a voxel.
    pub thin: u32,
    /// One of them.
    pub thin_at: Option<DVec3>,
}

impl Staged {
    /// To be filled.
    pub fn new() -> Self {
        Self {
            origin: IVec3::ZERO,
            distances: [0.0; BLOCK_VOXELS],
            normals: [[0.0; BLOCK_VOXELS]; 3],
            thin: 0,
            thin_at: None,
        }
    }

    /// A voxel's foot, as an offset from the voxel; `None` where none was found.
    pub fn to_foot(&self, i: usize) -> Option<Vec3> {
        let distance = self.distances[i];
        let normal = Vec3::new(self.normals[0][i], self.normals[1][i], self.normals[2][i]);
        (distance.abs() < f32::INFINITY).then(|| normal * -distance)
    }
}

/// Turns staged blocks into finished ones, on one thread.
pub struct Finisher {
    scope: Scope,
    background: f32,
    points: Points,
    feet: Points,
    distances: Box<[f32; BLOCK_VOXELS]>,
    normals: Box<[[f32; BLOCK_VOXELS]; 3]>,
    active: BlockMask,
    origin: IVec3,
}

impl Finisher {
    pub fn new(scope: &Scope) -> Self {
        Self {
            scope: *scope,
            background: scope.background(),
            points: Points::new(DVec3::ZERO),
            feet: Points::new(DVec3::ZERO),
            distances: Box::new([0.0; BLOCK_VOXELS]),
            normals: Box::new([[0.0; BLOCK_VOXELS]; 3]),
            active: [0; 8],
            origin: IVec3::ZERO,
        }
    }

    /// Clamps the distances and sets the mask; the result is then [`Finisher::block`].
    pub fn finish(&mut self, staged: &Staged) -> Kind {
        self.origin = staged.origin;
        self.active = clamp(&staged.distances, self.background, &mut self.distances);
        if self.active == [0; 8] {
            return if staged.distances[0] >= 0.0 { Kind::Inside } else { Kind::Outside };
        }
        self.points = Points::of_block(staged.origin, &self.scope.lattice);
        (self.feet.origin, self.feet.len) = (self.points.origin, BLOCK_VOXELS);
        for (of_points, of_feet, axis) in [
            (&self.points.x, &mut self.feet.x, 0),
            (&self.points.y, &mut self.feet.y, 1),
            (&self.points.z, &mut self.feet.z, 2),
        ] {
            let normals = &mut self.normals[axis];
            walk_to_feet(&self.distances, self.background, &staged.normals[axis], of_points, normals, of_feet);
        }
        Kind::Band
    }

    /// The block finished last, where it holds active voxels.
    pub fn block(&self) -> MeasuredBlock<'_> {
        MeasuredBlock {
            origin: self.origin,
            lattice: self.scope.lattice,
            region: self.scope.centres(self.origin, BLOCK_EDGE, f64::from(self.scope.half_width) + ROOM),
            points: &self.points,
            distances: &self.distances,
            active: &self.active,
            feet: &self.feet,
            normals: &self.normals,
        }
    }
}

/// Clamps signed distances to ± the background; the mask is of those that are nearer.
#[multiversion(targets = "simd")]
fn clamp(distances: &[f32; BLOCK_VOXELS], background: f32, clamped: &mut [f32; BLOCK_VOXELS]) -> BlockMask {
    let mut active = [0; BLOCK_VOXELS];
    for i in 0..BLOCK_VOXELS {
        active[i] = u8::from(distances[i].abs() < background);
        clamped[i] = distances[i].clamp(-background, background);
    }
    mask::pack(&active)
}

/// One axis of the normals and feet of active voxels; inactive ones have none.
#[multiversion(targets = "simd")]
fn walk_to_feet(
    distances: &[f32; BLOCK_VOXELS],
    background: f32,
    staged: &[f32; BLOCK_VOXELS],
    points: &[f32; BLOCK_VOXELS],
    normals: &mut [f32; BLOCK_VOXELS],
    feet: &mut [f32; BLOCK_VOXELS],
) {
    for i in 0..BLOCK_VOXELS {
        let normal = if distances[i].abs() < background { staged[i] } else { 0.0 };
        normals[i] = normal;
        feet[i] = points[i] - distances[i] * normal;
    }
}
