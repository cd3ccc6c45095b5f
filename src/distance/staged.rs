//! What is known of a block: while its neighbours may still offer nearer feet, and when it is finished.

use glam::{DVec3, IVec3, Vec3};
use multiversion::multiversion;

use crate::{
    field::{Aabb, Points},
    grid::{BLOCK_EDGE, BLOCK_VOXELS, BlockMask, Lattice, is_active},
};

use super::{descent::Scope, facing::Side};

/// Room around a block, in voxels beyond the half width, in which its feet are sought.
pub const ROOM: f64 = 1.0;

/// The edge in voxels of a node whose blocks share what is found out over it. Larger shares more, smaller leaves less
/// to be found out over each block.
const SHARED_EDGE: i32 = 64;

/// A finished block, as visitors see it.
pub struct MeasuredBlock<'a> {
    /// The block's least corner.
    pub origin: IVec3,
    /// Where the voxels stand.
    pub lattice: Lattice,
    /// A box that holds all voxel centres and feet.
    pub region: Aabb,
    /// The same of the larger node that the block is in: what is found out over it serves many blocks.
    pub node_region: Aabb,
    /// Signed distances of active voxels, world units, positive inside. Beyond the background at others.
    pub distances: &'a [f32; BLOCK_VOXELS],
    /// Voxels nearer to the surface than the background.
    pub active: &'a BlockMask,
    /// Gradients of the distance at active voxels: unit vectors pointing inward, x, y and z. Of no meaning at others.
    pub normals: &'a [[f32; BLOCK_VOXELS]; 3],
}

impl<'a> MeasuredBlock<'a> {
    /// A staged block that is finished.
    pub fn new(scope: &Scope, staged: &'a Staged) -> Self {
        let Staged { origin, distances, normals, active, .. } = staged;
        let margin = f64::from(scope.half_width) + ROOM;
        let region = scope.centres(*origin, BLOCK_EDGE, margin);
        let node_region = scope.centres(origin & IVec3::splat(!(SHARED_EDGE - 1)), SHARED_EDGE, margin);
        Self { origin: *origin, lattice: scope.lattice, region, node_region, distances, active, normals }
    }

    /// The closest surface point of each active voxel; an inactive voxel's own centre.
    pub fn feet(&self) -> Points {
        let mut feet = Points::of_block(self.origin, &self.lattice);
        for (feet, normals) in [&mut feet.x, &mut feet.y, &mut feet.z].into_iter().zip(self.normals) {
            walk_to_feet(self.distances, self.active, normals, feet);
        }
        feet
    }
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
    /// The voxels nearer to the surface than the background.
    pub active: BlockMask,
    /// What neighbours look at, by face: a fraction of the block's memory.
    pub sides: [Side; 6],
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
            active: [0; 8],
            sides: [Side::NONE; 6],
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

    /// The distances clamped to ± the background.
    pub fn clamped(&self, background: f32) -> [f32; BLOCK_VOXELS] {
        clamped(&self.distances, background)
    }
}

#[multiversion(targets = "simd")]
fn clamped(distances: &[f32; BLOCK_VOXELS], background: f32) -> [f32; BLOCK_VOXELS] {
    distances.map(|distance| distance.clamp(-background, background))
}

/// Moves active voxels along one axis to their feet.
#[multiversion(targets = "simd")]
fn walk_to_feet(
    distances: &[f32; BLOCK_VOXELS],
    active: &BlockMask,
    normals: &[f32; BLOCK_VOXELS],
    positions: &mut [f32; BLOCK_VOXELS],
) {
    for i in 0..BLOCK_VOXELS {
        let step = if is_active(active, i) { distances[i] * normals[i] } else { 0.0 };
        positions[i] -= step;
    }
}
