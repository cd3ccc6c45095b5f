//! Feet handed from voxel to voxel: the vector distance transform (Danielsson) inside a block.
//!
//! A voxel's own Newton iteration finds *a* foot; a neighbour's may be nearer. Sweeps along each axis and back carry
//! the nearest foot seen so far through the block, as the transform does, with sub-voxel feet on F = 0. What blocks have
//! for each other is in [`super::facing`].

use multiversion::multiversion;

use crate::{field::Points, grid::BLOCK_VOXELS};

/// How much nearer a neighbour's foot must be to be taken, in voxels: feet are right to about a hundredth, and
/// smaller would polish again what is already right.
pub const NEARER: f32 = 0.01;

/// Replaces each voxel's foot by a nearer one of a neighbour's; returns whether any was, and marks them in `changed`.
/// Feet well beyond `reach` are not offered: the voxel is not in the band.
pub fn sweep(
    voxel: f32,
    reach: f32,
    points: &Points,
    feet: &mut Points,
    distances: &mut [f32; BLOCK_VOXELS],
    changed: &mut [bool; BLOCK_VOXELS],
) -> bool {
    if !any_nearer(voxel, reach, points, feet, distances) {
        return false;
    }
    let mut any = false;
    for stride in [64, 8, 1] {
        // Whether a step by `stride` from i stays in the block.
        let last = |i: usize| (i / stride) % 8 == 7;
        for i in (0..BLOCK_VOXELS).filter(|&i| !last(i)) {
            any |= offer(voxel, reach, points, feet, distances, changed, [i, i + stride]);
        }
        for i in (0..BLOCK_VOXELS).rev().filter(|&i| !last(i)) {
            any |= offer(voxel, reach, points, feet, distances, changed, [i + stride, i]);
        }
    }
    any
}

/// How far beyond reach a foot is still taken, in voxels: polishing brings it nearer. A neighbour's foot is off by about
/// a voxel along the surface, at most a sixth of a voxel in distance at reach 3.
const BEYOND: f32 = 0.25;

/// The square of the distance that an offered foot must undercut.
#[inline(always)]
pub fn limit_of(voxel: f32, reach: f32, distance: f32) -> f32 {
    let limit = (distance - NEARER * voxel).min(reach + BEYOND * voxel).max(0.0);
    limit * limit
}

/// Whether a voxel's neighbour by one is in its row. Looked up, for short rows make short vectors.
const HAS_NEXT: [u32; BLOCK_VOXELS] = {
    let mut has_next = [1; BLOCK_VOXELS];
    let mut last = 7;
    while last < BLOCK_VOXELS {
        has_next[last] = 0;
        last += 8;
    }
    has_next
};

/// The square of the distance from a foot to the voxel's neighbour at `step` along an axis, by the square of its own
/// distance and the way from its foot to it along the axis.
#[inline(always)]
pub fn square_beside(square: f32, way: f32, step: f32) -> f32 {
    square + step * (2.0 * way + step)
}

/// Whether a sweep would find anything: the usual answer is no, and a plain loop finds that out fast.
#[multiversion(targets = "simd")]
fn any_nearer(voxel: f32, reach: f32, points: &Points, feet: &Points, distances: &[f32; BLOCK_VOXELS]) -> bool {
    let mut limits = [0.0; BLOCK_VOXELS];
    for i in 0..BLOCK_VOXELS {
        limits[i] = limit_of(voxel, reach, distances[i]);
    }
    let (mut onward, mut back) = ([0.0; BLOCK_VOXELS], [0.0; BLOCK_VOXELS]);
    let mut any = 0;
    for (stride, points, feet) in [(64, &points.x, &feet.x), (8, &points.y, &feet.y), (1, &points.z, &feet.z)] {
        for i in 0..BLOCK_VOXELS {
            let (square, way) = (distances[i] * distances[i], points[i] - feet[i]);
            onward[i] = square_beside(square, way, voxel);
            back[i] = square_beside(square, way, -voxel);
        }
        if stride == 1 {
            for low in 0..BLOCK_VOXELS - 1 {
                let nearer = (onward[low] < limits[low + 1]) | (back[low + 1] < limits[low]);
                any |= HAS_NEXT[low] & u32::from(nearer);
            }
            continue;
        }
        // Runs of voxels whose neighbours at `stride` are in the block.
        for start in (0..BLOCK_VOXELS).step_by(8 * stride) {
            for low in start..start + 7 * stride {
                any |= u32::from((onward[low] < limits[low + stride]) | (back[low + stride] < limits[low]));
            }
        }
    }
    any != 0
}

fn offer(
    voxel: f32,
    reach: f32,
    points: &Points,
    feet: &mut Points,
    distances: &mut [f32; BLOCK_VOXELS],
    changed: &mut [bool; BLOCK_VOXELS],
    [from, to]: [usize; 2],
) -> bool {
    if distances[from] == f32::INFINITY {
        return false;
    }
    let square = (feet.offset(from) - points.offset(to)).length_squared();
    let nearer = square < limit_of(voxel, reach, distances[to]);
    if nearer {
        distances[to] = square.sqrt();
        (feet.x[to], feet.y[to], feet.z[to]) = (feet.x[from], feet.y[from], feet.z[from]);
        changed[to] = true;
    }
    nearer
}

/// How much more than a voxel the distances of two neighbours of different sign may add up to, in voxels: feet are
/// right to a hundredth each.
const CROSSED: f32 = 1.0 + 2.0 * NEARER;

/// Whether two neighbouring voxels with these signed distances are of different sign, and both farther from the surface
/// than they can be: it passes between them.
#[inline(always)]
pub fn miss_a_crossing(voxel: f32, here: f32, there: f32) -> bool {
    ((here >= 0.0) != (there >= 0.0)) & (here.abs() + there.abs() > CROSSED * voxel)
}

/// Whether any two neighbours in a block miss a crossing. The usual answer is no, and a plain loop finds that out fast.
#[multiversion(targets = "simd")]
pub fn any_crossing_missed(voxel: f32, signed: &[f32; BLOCK_VOXELS]) -> bool {
    let mut any = 0;
    for stride in [64, 8] {
        for start in (0..BLOCK_VOXELS).step_by(8 * stride) {
            for low in start..start + 7 * stride {
                any |= u32::from(miss_a_crossing(voxel, signed[low], signed[low + stride]));
            }
        }
    }
    for low in 0..BLOCK_VOXELS - 1 {
        any |= HAS_NEXT[low] & u32::from(miss_a_crossing(voxel, signed[low], signed[low + 1]));
    }
    any != 0
}
