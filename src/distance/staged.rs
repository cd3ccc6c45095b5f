//! What is known of a block: while its neighbours may still offer nearer feet, and when it is finished.

use glam::{DVec3, IVec3, Vec3};
use multiversion::multiversion;

use crate::{
    field::{Aabb, BATCH, Points},
    grid::{BLOCK_EDGE, BLOCK_VOXELS, BlockMask, Lattice, node_origin},
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
        let node_region = scope.centres(node_origin(*origin, SHARED_EDGE), SHARED_EDGE, margin);
        Self { origin: *origin, lattice: scope.lattice, region, node_region, distances, active, normals }
    }

    /// Puts the closest surface points of the active voxels into `feet`, one after the other: most voxels of a block have
    /// none. What `feet` held is forgotten.
    pub fn feet_into(&self, feet: &mut Points) {
        feet.origin = Points::middle_of_block(self.origin, &self.lattice);
        walk_to_feet(self, &Points::offsets_in_block(&self.lattice), feet);
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
    /// About how thick the feature is there, world units; 0 where that is not known.
    pub thin_size: f32,
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
            thin_size: 0.0,
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

/// Puts in the feet of the active voxels, row after row along z. `places` are the offsets of a row's voxels.
#[multiversion(targets = "simd")]
fn walk_to_feet(block: &MeasuredBlock, places: &[f32; BLOCK_EDGE as usize], feet: &mut Points) {
    const ROW: usize = BLOCK_EDGE as usize;
    let distances = block.distances.as_chunks::<ROW>().0;
    let normals = block.normals.each_ref().map(|normals| normals.as_chunks::<ROW>().0);
    let mut len = 0;
    for row in 0..BLOCK_VOXELS / ROW {
        let flags = block.active[row / ROW] >> (ROW * (row % ROW)) & 0xFF;
        if flags == 0 {
            continue;
        }
        let mut found = [[places[row / ROW]; ROW], [places[row % ROW]; ROW], *places];
        for (found, normals) in found.iter_mut().zip(normals) {
            for i in 0..ROW {
                found[i] -= distances[row][i] * normals[row][i];
            }
        }
        let offsets = [&mut feet.x, &mut feet.y, &mut feet.z];
        if flags == 0xFF && len + ROW <= BATCH {
            for (offsets, found) in offsets.into_iter().zip(&found) {
                offsets[len..len + ROW].copy_from_slice(found);
            }
            len += ROW;
            continue;
        }
        let [x, y, z] = offsets;
        // Each is written to the next place, which only an active one takes up: no branch that could be guessed wrong.
        for i in 0..ROW {
            let at = len % BATCH;
            (x[at], y[at], z[at]) = (found[0][i], found[1][i], found[2][i]);
            len += (flags >> i & 1) as usize;
        }
    }
    feet.len = len;
    if len < BATCH {
        (feet.x[len], feet.y[len], feet.z[len]) = (0.0, 0.0, 0.0);
    }
}
