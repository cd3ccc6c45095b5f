//! Feet handed from voxel to voxel: the vector distance transform (Danielsson) inside a block.
//!
//! A voxel's own Newton iteration finds *a* foot; a neighbour's may be nearer. Sweeps along each axis and back carry
//! the nearest foot seen so far through the block, as the transform does, with sub-voxel feet on F = 0.

use crate::{field::Points, grid::BLOCK_VOXELS};

/// How much nearer a neighbour's foot must be to be taken, in voxels: feet are right to about a hundredth, and
/// smaller would polish again what is already right.
pub const NEARER: f32 = 0.01;

/// Replaces each voxel's foot by a nearer one of a neighbour's; returns whether any was, and marks them in `changed`.
pub fn sweep(
    voxel: f32,
    points: &Points,
    feet: &mut Points,
    distances: &mut [f32; BLOCK_VOXELS],
    changed: &mut [bool; BLOCK_VOXELS],
) -> bool {
    let mut any = false;
    for stride in [64, 8, 1] {
        // Whether a step by `stride` from i stays in the block.
        let last = |i: usize| (i / stride) % 8 == 7;
        for i in (0..BLOCK_VOXELS).filter(|&i| !last(i)) {
            any |= offer(voxel, points, feet, distances, changed, i, i + stride);
        }
        for i in (0..BLOCK_VOXELS).rev().filter(|&i| !last(i)) {
            any |= offer(voxel, points, feet, distances, changed, i + stride, i);
        }
    }
    any
}

fn offer(
    voxel: f32,
    points: &Points,
    feet: &mut Points,
    distances: &mut [f32; BLOCK_VOXELS],
    changed: &mut [bool; BLOCK_VOXELS],
    from: usize,
    to: usize,
) -> bool {
    if distances[from] == f32::INFINITY {
        return false;
    }
    let (dx, dy, dz) = (feet.x[from] - points.x[to], feet.y[from] - points.y[to], feet.z[from] - points.z[to]);
    let distance = (dx * dx + dy * dy + dz * dz).sqrt();
    let nearer = distance < distances[to] - NEARER * voxel;
    if nearer {
        distances[to] = distance;
        (feet.x[to], feet.y[to], feet.z[to]) = (feet.x[from], feet.y[from], feet.z[from]);
        changed[to] = true;
    }
    nearer
}
