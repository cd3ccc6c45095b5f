//! Plain loops over a block's voxels, compiled for several vector widths; the widths agree bit for bit.

use std::hint::select_unpredictable;

use multiversion::multiversion;

use crate::{
    field::{Gradients, Points},
    grid::{BLOCK_VOXELS, BlockMask, mask},
};

/// Voxels of a few rows along z, which are often all far from the surface.
const ROWS: usize = 16;

/// Distances with the sign of F, world units.
#[multiversion(targets = "simd")]
pub fn signed(values: &[f32; BLOCK_VOXELS], distances: &[f32; BLOCK_VOXELS], signed: &mut [f32; BLOCK_VOXELS]) {
    for i in 0..BLOCK_VOXELS {
        signed[i] = if values[i] >= 0.0 { distances[i] } else { -distances[i] };
    }
}

/// The voxels nearer to the surface than the background.
#[multiversion(targets = "simd")]
pub fn active(distances: &[f32; BLOCK_VOXELS], background: f32) -> BlockMask {
    let mut active = [0; BLOCK_VOXELS];
    for i in 0..BLOCK_VOXELS {
        active[i] = u8::from(distances[i].abs() < background);
    }
    mask::pack(&active)
}

/// The gradients of the distance: along the way to the foot, or where that is too short to have a direction, F's;
/// zero where there is no foot.
#[multiversion(targets = "simd")]
pub fn normals(
    points: &Points,
    feet: &Points,
    at_voxels: &Gradients,
    signed: &[f32; BLOCK_VOXELS],
    voxel: f32,
    normals: &mut [[f32; BLOCK_VOXELS]; 3],
) {
    let [nx, ny, nz] = normals;
    // Nearer than this the way to the foot has no direction.
    let shortest = 0.05 * voxel;
    for first in (0..BLOCK_VOXELS).step_by(ROWS) {
        let rows = first..first + ROWS;
        let (mut found, mut close) = (false, false);
        for i in rows.clone() {
            found |= signed[i].abs() < f32::INFINITY;
            close |= signed[i].abs() <= shortest;
        }
        if !found {
            for normals in [&mut *nx, &mut *ny, &mut *nz] {
                normals[rows.clone()].fill(0.0);
            }
            continue;
        }
        if !close {
            for i in rows {
                // As long as the way to the foot is. Where there is none, 1/∞.
                let inverse = 1.0 / signed[i];
                let has = signed[i].abs() < f32::INFINITY;
                nx[i] = select_unpredictable(has, (points.x[i] - feet.x[i]) * inverse, 0.0);
                ny[i] = select_unpredictable(has, (points.y[i] - feet.y[i]) * inverse, 0.0);
                nz[i] = select_unpredictable(has, (points.z[i] - feet.z[i]) * inverse, 0.0);
            }
            continue;
        }
        for i in rows {
            let sign = if at_voxels.value[i] >= 0.0 { 1.0 } else { -1.0 };
            let far = signed[i].abs() > shortest;
            // Both are read, and one chosen: a read that depends on which would be a masked one.
            let x = select_unpredictable(far, (points.x[i] - feet.x[i]) * sign, at_voxels.dx[i]);
            let y = select_unpredictable(far, (points.y[i] - feet.y[i]) * sign, at_voxels.dy[i]);
            let z = select_unpredictable(far, (points.z[i] - feet.z[i]) * sign, at_voxels.dz[i]);
            let inverse = 1.0 / (x * x + y * y + z * z).sqrt();
            let has = (inverse < f32::INFINITY) & (inverse > 0.0) & (signed[i].abs() < f32::INFINITY);
            nx[i] = select_unpredictable(has, x * inverse, 0.0);
            ny[i] = select_unpredictable(has, y * inverse, 0.0);
            nz[i] = select_unpredictable(has, z * inverse, 0.0);
        }
    }
}

/// Voxels that have a neighbour in the block on the other side of the surface.
#[multiversion(targets = "simd")]
pub fn beside_other_sign(values: &[f32; BLOCK_VOXELS]) -> BlockMask {
    let mut inside = [0; BLOCK_VOXELS];
    for i in 0..BLOCK_VOXELS {
        inside[i] = u8::from(values[i] >= 0.0);
    }
    beside_others(&mask::pack(&inside))
}

/// Whether a voxel lies on one of the block's faces.
#[inline(always)]
pub fn is_on_border(i: usize) -> bool {
    [i >> 6, i >> 3 & 7, i & 7].into_iter().any(|at| at == 0 || at == 7)
}

/// Distances to the surface below this, in voxels, count as on it: what lies no deeper is not held by its voxel.
pub const ON_SURFACE: f32 = 0.05;

/// Voxels within half a voxel's diagonal of the surface that have no neighbour in the block on the other side of it.
/// Those on the surface count as outside: a feature that none but they see has no inside in the grid.
#[multiversion(targets = "simd")]
pub fn beside_surface(values: &[f32; BLOCK_VOXELS], distances: &[f32; BLOCK_VOXELS], voxel: f32) -> BlockMask {
    let mut near = [0; BLOCK_VOXELS];
    for i in 0..BLOCK_VOXELS {
        near[i] = u8::from(distances[i] <= 0.87 * voxel);
    }
    let near = mask::pack(&near);
    if near == [0; 8] {
        return near;
    }
    let mut inside = [0; BLOCK_VOXELS];
    for i in 0..BLOCK_VOXELS {
        inside[i] = u8::from((values[i] >= 0.0) & (distances[i] >= ON_SURFACE * voxel));
    }
    let crossed = beside_others(&mask::pack(&inside));
    std::array::from_fn(|x| near[x] & !crossed[x])
}

/// The voxels that have one of the other kind for a neighbour in the block.
#[inline(always)]
fn beside_others(mask: &BlockMask) -> BlockMask {
    let (by_set, by_clear) = (mask::dilated(mask), mask::dilated(&mask.map(|word| !word)));
    std::array::from_fn(|x| if_inside(mask[x], by_clear[x], by_set[x]))
}

/// Bit by bit, `yes` where `mask` is set and `no` elsewhere.
#[inline(always)]
fn if_inside(mask: u64, yes: u64, no: u64) -> u64 {
    mask & yes | !mask & no
}
