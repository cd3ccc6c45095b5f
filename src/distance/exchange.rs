//! Feet handed from voxel to voxel: the vector distance transform (Danielsson) inside a block.
//!
//! A voxel's own Newton iteration finds *a* foot; a neighbour's may be nearer. Sweeps along each axis and back carry
//! the nearest foot seen so far through the block, as the transform does, with sub-voxel feet on F = 0. What blocks have
//! for each other is in [`super::facing`].

use multiversion::multiversion;

use super::polish::within;
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
    let limit = within(distance - NEARER * voxel, 0.0, reach + BEYOND * voxel);
    limit * limit
}

/// Whether a voxel's next one along z is in its row. Looked up, for short rows make short vectors.
const HAS_NEXT_Z: [u32; BLOCK_VOXELS] = has_next(1);

/// Whether a voxel's next one along y is in its slab.
const HAS_NEXT_Y: [u32; BLOCK_VOXELS] = has_next(8);

/// Whether a voxel is not the last along the axis whose steps are by `stride`.
const fn has_next(stride: usize) -> [u32; BLOCK_VOXELS] {
    let mut has_next = [0; BLOCK_VOXELS];
    let mut voxel = 0;
    while voxel < BLOCK_VOXELS {
        has_next[voxel] = (voxel / stride % 8 != 7) as u32;
        voxel += 1;
    }
    has_next
}

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
    // Whether one of two neighbours along an axis has a nearer foot for the other.
    let either = |points: &[f32; BLOCK_VOXELS], feet: &[f32; BLOCK_VOXELS], low: usize, high: usize| {
        let onward = square_beside(distances[low] * distances[low], points[low] - feet[low], voxel);
        let back = square_beside(distances[high] * distances[high], points[high] - feet[high], -voxel);
        u32::from((onward < limits[high]) | (back < limits[low]))
    };
    let mut any = 0;
    for low in 0..BLOCK_VOXELS - 64 {
        any |= either(&points.x, &feet.x, low, low + 64);
    }
    for low in 0..BLOCK_VOXELS - 8 {
        any |= HAS_NEXT_Y[low] & either(&points.y, &feet.y, low, low + 8);
        any |= HAS_NEXT_Z[low] & either(&points.z, &feet.z, low, low + 1);
    }
    // The last row's, which the loop before does not reach.
    for low in BLOCK_VOXELS - 9..BLOCK_VOXELS - 1 {
        any |= HAS_NEXT_Z[low] & either(&points.z, &feet.z, low, low + 1);
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
/// than they can be: it passes between them. A voxel outside that lies on the surface has the distance −0.
#[inline(always)]
pub fn miss_a_crossing(voxel: f32, here: f32, there: f32) -> bool {
    (here.is_sign_negative() != there.is_sign_negative()) & (here.abs() + there.abs() > CROSSED * voxel)
}

/// Whether any two neighbours in a block miss a crossing. The usual answer is no, and a plain loop finds that out fast.
#[multiversion(targets = "simd")]
pub fn any_crossing_missed(voxel: f32, signed: &[f32; BLOCK_VOXELS]) -> bool {
    let (mut inside, mut outside) = (0, 0);
    for distance in signed {
        inside |= u32::from(distance.is_sign_positive());
        outside |= u32::from(distance.is_sign_negative());
    }
    if inside == 0 || outside == 0 {
        return false;
    }
    let missed = |low: usize, high: usize| u32::from(miss_a_crossing(voxel, signed[low], signed[high]));
    let mut any = 0;
    for low in 0..BLOCK_VOXELS - 64 {
        any |= missed(low, low + 64);
    }
    for low in 0..BLOCK_VOXELS - 8 {
        any |= HAS_NEXT_Y[low] & missed(low, low + 8) | HAS_NEXT_Z[low] & missed(low, low + 1);
    }
    // The last row's, which the loop before does not reach.
    for low in BLOCK_VOXELS - 9..BLOCK_VOXELS - 1 {
        any |= HAS_NEXT_Z[low] & missed(low, low + 1);
    }
    any != 0
}
