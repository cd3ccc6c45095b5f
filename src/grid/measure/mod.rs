//! What a band tells about its solid: volume, change from one band to the next, pieces, and whether its values are
//! those of a distance. Pure functions; nothing here changes a band or knows where it came from.
//!
//! Volumes count a voxel by the **share** of it that is solid, clamp(F/h + 1/2, 0, 1) for the voxel size h. That is
//! exact for a plane across an axis; a sphere of radius r voxels reads 1/(4r²) too large.

mod edges;
mod hollows;
mod lookup;
mod pieces;
mod soundness;

pub use hollows::hollows;
pub use lookup::{Lookup, Place, Surroundings, local_of};
pub use pieces::{pieces, voxels_of_pieces};
pub use soundness::{Pairs, SlopeError, slope_error, steep_steps, tears};

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use self::lookup::voxel_of;
use super::{BLOCK_VOXELS, Band, InsideTile};

/// The solid's volume, in cubic world units.
pub fn volume(band: &Band) -> f64 {
    let inverse = 1.0 / band.lattice.voxel_size.get();
    let sums: Vec<f64> = band.distances.par_iter().map(|block| solid_voxels(block, inverse)).collect();
    let tiles: f64 = band.inside_tiles.iter().map(tile_volume).sum();
    (sums.iter().sum::<f64>() + tiles) * cubed(band)
}

/// The area of the solid's surface, in square world units: how much volume lies between levels close to it, by a
/// smoothed delta function. A sphere of radius r voxels reads 0.29/r² too large, a corner is rounded.
pub fn area(band: &Band) -> f64 {
    /// Half the width of the smoothed delta, in voxels: at 1.5 the sum over voxels is even wherever a plane stands.
    const HALF: f64 = 1.5;
    let inverse = 1.0 / band.lattice.voxel_size.get();
    let of_voxel = |distance: &f32| {
        let away = f64::from(*distance) * inverse / HALF;
        if away.abs() < 1.0 { (1.0 + libm::cos(std::f64::consts::PI * away)) / (2.0 * HALF) } else { 0.0 }
    };
    let sums: Vec<f64> = band.distances.par_iter().map(|block| block.iter().map(of_voxel).sum()).collect();
    sums.iter().sum::<f64>() * band.lattice.voxel_size.get().powi(2)
}

/// The volume that lies in one solid and not in the other, in cubic world units; `None` where the two bands stand
/// on different lattices.
pub fn change(first: &Band, second: &Band) -> Option<f64> {
    if first.lattice != second.lattice {
        return None;
    }
    let (in_first, in_second) = (Lookup::new(first), Lookup::new(second));
    let inverse = 1.0 / first.lattice.voxel_size.get();
    let differences: Vec<f64> = (0..first.origins.len())
        .into_par_iter()
        .map(|index| block_difference(&first.distances[index], in_second.at(first.origins[index]), second, inverse))
        .collect();
    let only_second: Vec<f64> = (0..second.origins.len())
        .into_par_iter()
        .filter(|&index| !matches!(in_first.at(second.origins[index]), Place::Voxel { .. }))
        .map(|index| block_difference(&second.distances[index], in_first.at(second.origins[index]), first, inverse))
        .collect();
    let voxels = differences.iter().sum::<f64>() + only_second.iter().sum::<f64>();
    let tiles = tile_difference(first, &in_first, second, &in_second);
    Some((voxels + tiles) * cubed(first))
}

/// Less deep inside than this share of a voxel is not inside: rounding makes as much of a skin without thickness.
const NO_DEPTH: f64 = 0.05;

/// How deep inside the deepest voxel lies, in world units; negative where all are outside.
pub fn deepest(band: &Band) -> f64 {
    let voxels = band.distances.par_iter().map(|block| block.iter().copied().fold(f32::NEG_INFINITY, f32::max));
    let in_blocks = voxels.reduce(|| f32::NEG_INFINITY, f32::max);
    let half_width = band.half_width * band.lattice.voxel_size.get() as f32;
    f64::from(if band.inside_tiles.is_empty() { in_blocks } else { in_blocks.max(half_width) })
}

/// Whether the solid holds anything that can be meshed.
pub fn has_inside(band: &Band) -> bool {
    let least = NO_DEPTH * band.lattice.voxel_size.get();
    // The first voxel found is enough.
    let is_deep = |block: &[f32; BLOCK_VOXELS]| block.iter().any(|&distance| f64::from(distance) > least);
    !band.inside_tiles.is_empty() || band.distances.par_iter().any(is_deep)
}

/// A change of less than this share of the volume is none: rounding.
const NO_CHANGE: f64 = 1e-6;

/// The median of the changes from frame to frame, of those that change anything: a morph may rest for most of its shot.
/// `volume` is the greatest of any frame. `None` where nothing changes.
pub fn median_of_moving(changes: &[f64], volume: f64) -> Option<f64> {
    let mut moving: Vec<f64> =
        changes.iter().copied().filter(|change| change.is_finite() && *change > NO_CHANGE * volume).collect();
    moving.sort_by(f64::total_cmp);
    moving.get(moving.len() / 2).copied()
}

/// The least box around the centres of all voxels inside, in world units: its least and greatest corner. `None`
/// where the solid holds no voxel.
pub fn solid_extent(band: &Band) -> Option<(DVec3, DVec3)> {
    let blocks = band.origins.par_iter().zip(&band.distances).filter_map(|(&origin, block)| {
        let inside = (0..BLOCK_VOXELS).filter(|&offset| block[offset] >= 0.0).map(|offset| voxel_of(origin, offset));
        inside.map(|voxel| (voxel, voxel)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    });
    let tiles =
        band.inside_tiles.par_iter().map(|tile| (tile.origin, tile.origin.saturating_add(IVec3::splat(tile.edge - 1))));
    let (min, max) = blocks.chain(tiles).reduce_with(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
    Some((band.lattice.centre(min), band.lattice.centre(max)))
}

/// The volume in a block, in voxels. The sums are of every eighth voxel, then of these, at any vector width.
#[multiversion::multiversion(targets = "simd")]
fn solid_voxels(block: &[f32; BLOCK_VOXELS], inverse_size: f64) -> f64 {
    let mut sums = [0.0; 8];
    for row in block.as_chunks::<8>().0 {
        for z in 0..8 {
            sums[z] += share(row[z], inverse_size);
        }
    }
    sums.iter().sum()
}

/// The solid share of a voxel, 0 to 1.
#[inline(always)]
fn share(value: f32, inverse_size: f64) -> f64 {
    (f64::from(value) * inverse_size + 0.5).clamp(0.0, 1.0)
}

fn cubed(band: &Band) -> f64 {
    let size = band.lattice.voxel_size.get();
    size * size * size
}

/// A tile's volume in voxels.
fn tile_volume(tile: &InsideTile) -> f64 {
    let edge = f64::from(tile.edge);
    edge * edge * edge
}

/// The difference, in voxels, of a block and what the other band has in its place.
fn block_difference(block: &[f32; BLOCK_VOXELS], place: Place, other: &Band, inverse: f64) -> f64 {
    let against = |value: f64| block.iter().map(|&own| (share(own, inverse) - value).abs()).sum();
    match place {
        Place::Outside => against(0.0),
        Place::Tile(_) => against(1.0),
        Place::Voxel { block: index, .. } => {
            let pairs = block.iter().zip(&other.distances[index]);
            pairs.map(|(&own, &value)| (share(own, inverse) - share(value, inverse)).abs()).sum()
        }
    }
}

/// The difference, in voxels, where neither band has blocks: all tiles, less what the other band has in their place.
/// Tiles are nested or apart, so the overlap of two is the smaller of them.
fn tile_difference(first: &Band, in_first: &Lookup<'_>, second: &Band, in_second: &Lookup<'_>) -> f64 {
    let all = |band: &Band| band.inside_tiles.iter().map(tile_volume).sum::<f64>();
    let blocks_in_tiles = |band: &Band, lookup: &Lookup<'_>| {
        let in_tile = |&&origin: &&IVec3| matches!(lookup.at(origin), Place::Tile(_));
        (band.origins.iter().filter(in_tile).count() * BLOCK_VOXELS) as f64
    };
    // The tiles of one band that lie in a tile of the other; those of equal size are counted from one side only.
    let tiles_in_tiles = |band: &Band, lookup: &Lookup<'_>, other: &Band, equal: bool| {
        let covered = |tile: &&InsideTile| match lookup.at(tile.origin) {
            Place::Tile(index) => {
                let around = other.inside_tiles[index].edge;
                around > tile.edge || (equal && around == tile.edge)
            }
            _ => false,
        };
        band.inside_tiles.iter().filter(covered).map(tile_volume).sum::<f64>()
    };
    let both = tiles_in_tiles(first, in_second, second, true) + tiles_in_tiles(second, in_first, first, false);
    all(first) + all(second) - 2.0 * both - blocks_in_tiles(first, in_second) - blocks_in_tiles(second, in_first)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::grid::testing::{band_of, sphere};

    /// The same solid with its 8³ tiles merged into 128³ tiles where they fill one.
    fn with_large_tiles(mut band: Band) -> Band {
        let mut counts = std::collections::BTreeMap::new();
        for tile in &band.inside_tiles {
            *counts.entry((tile.origin & IVec3::splat(!127)).to_array()).or_insert(0) += 1;
        }
        counts.retain(|_, count| *count == 16 * 16 * 16);
        assert!(!counts.is_empty(), "the solid is too small for this test");
        band.inside_tiles.retain(|tile| !counts.contains_key(&(tile.origin & IVec3::splat(!127)).to_array()));
        let merged = counts.keys().map(|&origin| InsideTile { origin: IVec3::from_array(origin), edge: 128 });
        band.inside_tiles.extend(merged);
        band.inside_tiles.sort_by_key(|tile| crate::grid::block_order(tile.origin));
        band
    }

    #[test]
    fn the_volume_of_a_sphere() {
        for (radius, size) in [(1.0, 0.04), (0.7, 0.01)] {
            let band = sphere(DVec3::new(0.11, -0.07, 0.013), radius, size);
            let exact = 4.0 / 3.0 * PI * radius * radius * radius;
            let error = volume(&band) / exact - 1.0;
            assert!(error.abs() < 1e-3, "radius {radius}: {error:e}");
            // What the share's ramp adds, to a tenth.
            let expected = size * size / (4.0 * radius * radius);
            assert!((error - expected).abs() < 1e-4, "radius {radius}: {error:e} for {expected:e}");
        }
    }

    #[test]
    fn the_area_of_a_sphere() {
        for (radius, size) in [(1.0, 0.04), (0.7, 0.01)] {
            let error =
                area(&sphere(DVec3::new(0.11, -0.07, 0.013), radius, size)) / (4.0 * PI * radius * radius) - 1.0;
            let expected = 0.294 * (size / radius) * (size / radius);
            assert!((error - expected).abs() < 3e-4, "radius {radius}: {error:e} for {expected:e}");
        }
    }

    #[test]
    fn the_change_of_a_sphere_that_moves() {
        let (radius, size) = (1.0, 0.025);
        let still = sphere(DVec3::ZERO, radius, size);
        assert_eq!(change(&still, &still), Some(0.0));
        for shift in [0.02, 0.3, 1.1, 3.0] {
            let moved = sphere(DVec3::new(shift, 0.0, 0.0), radius, size);
            // Two spheres of radius r at distance d share a lens of π(4r + d)(2r − d)²/12.
            let gap: f64 = (2.0 * radius - shift).max(0.0);
            let lens = PI * (4.0 * radius + shift) * gap * gap / 12.0;
            let exact = 2.0 * (4.0 / 3.0 * PI * radius * radius * radius - lens);
            let found = change(&still, &moved).unwrap();
            assert!((found / exact - 1.0).abs() < 2e-3, "shift {shift}: {found} for {exact}");
            assert_eq!(Some(found), change(&moved, &still));
        }
        assert_eq!(change(&still, &sphere(DVec3::ZERO, radius, 0.05)), None);
    }

    #[test]
    fn large_tiles_measure_as_small_ones() {
        // Faces half-way between voxels: every share is 0 or 1, and sums are exact.
        let cube = |centre: f64| band_of(move |p| 140.0 - (p - centre).abs().max_element(), 170.0, 1.0);
        let (small, moved) = (cube(0.5), cube(20.5));
        let (large, large_moved) = (with_large_tiles(small.clone()), with_large_tiles(moved.clone()));
        assert_eq!(volume(&small), 280.0_f64.powi(3));
        assert_eq!(volume(&large), volume(&small));
        let exact = 2.0 * (280.0_f64.powi(3) - 260.0_f64.powi(3));
        for (first, second) in [(&small, &moved), (&large, &large_moved), (&small, &large_moved), (&large, &moved)] {
            assert_eq!(change(first, second), Some(exact));
        }
        assert_eq!(change(&small, &large), Some(0.0));
        assert_eq!(pieces(&large), pieces(&small));
        assert_eq!((tears(&large), tears(&small)), (Pairs::default(), Pairs::default()));
        assert_eq!(solid_extent(&large), solid_extent(&small));
    }

    #[test]
    fn the_extent_of_a_solid() {
        let band = sphere(DVec3::new(1.0, 2.0, 3.0), 0.5, 0.1);
        let (min, max) = solid_extent(&band).unwrap();
        assert!((min - DVec3::new(0.5, 1.5, 2.5)).abs().max_element() < 0.11);
        assert!((max - DVec3::new(1.5, 2.5, 3.5)).abs().max_element() < 0.11);
        assert_eq!(solid_extent(&sphere(DVec3::splat(0.05), 0.01, 0.1)), None);
    }
}
