//! Whether a band's values are those of a distance: slope 1, and no sign that changes where no surface is.

use glam::IVec3;
use rayon::prelude::*;

use super::lookup::{Lookup, Place, local_of, voxel_of};
use crate::grid::{BLOCK_EDGE, BLOCK_VOXELS, Band, BlockMask, is_active};

/// How far the slope of the values is from 1. Creases and the medial axis count too: there the slope of the true
/// distance has a jump, and a difference quotient is less than 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SlopeError {
    /// The mean of | |∇F| − 1 |; 0 where no voxel was measured.
    pub mean: f64,
    /// The greatest | |∇F| − 1 |.
    pub max: f64,
    /// How many voxels were measured.
    pub voxels: u64,
    /// How many of them have | |∇F| − 1 | above 0.1.
    pub off: u64,
}

/// The slope by central differences at all voxels that lie at least a voxel and a half within the band, so that no
/// neighbour is clamped.
pub fn slope_error(band: &Band) -> SlopeError {
    let lookup = Lookup::new(band);
    let size = band.lattice.voxel_size.get();
    let limit = ((f64::from(band.half_width) - 1.5) * size) as f32;
    let blocks: Vec<SlopeError> = (0..band.origins.len())
        .into_par_iter()
        .map(|block| {
            let around = lookup.around(block);
            let mut sum = SlopeError::default();
            for offset in (0..BLOCK_VOXELS).filter(|&offset| band.distances[block][offset].abs() <= limit) {
                let local = local_of(offset);
                let slope = IVec3::AXES.map(|axis| {
                    (f64::from(around.value(local + axis)) - f64::from(around.value(local - axis))) / (2.0 * size)
                });
                let error = (slope.iter().map(|slope| slope * slope).sum::<f64>().sqrt() - 1.0).abs();
                sum = SlopeError {
                    mean: sum.mean + error,
                    max: sum.max.max(error),
                    voxels: sum.voxels + 1,
                    off: sum.off + u64::from(error > 0.1),
                };
            }
            sum
        })
        .collect();
    let mut total = SlopeError::default();
    for block in &blocks {
        total.mean += block.mean;
        total.max = total.max.max(block.max);
        total.voxels += block.voxels;
        total.off += block.off;
    }
    total.mean /= total.voxels.max(1) as f64;
    total
}

/// Pairs of neighbouring voxels (for tiles: of blocks) with something wrong between them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pairs {
    /// How many there are.
    pub pairs: u64,
    /// One voxel of the first pair, in the band's order.
    pub first: Option<IVec3>,
}

impl Pairs {
    /// All of several, in order.
    fn sum(found: &[Self]) -> Self {
        let pairs = found.iter().map(|pairs| pairs.pairs).sum();
        Self { pairs, first: found.iter().find_map(|pairs| pairs.first) }
    }
}

/// Finds neighbours in one block, both within the band, whose values differ by more than 1.2 times the voxel between
/// them: a distance differs by 1 at most, one with the errors of a sound one by a little more.
pub fn steep_steps(band: &Band) -> Pairs {
    let most = (1.2 * band.lattice.voxel_size.get()) as f32;
    let of_block = |(origin, (values, mask)): (&IVec3, (&[f32; BLOCK_VOXELS], &BlockMask))| {
        let mut steep = Pairs::default();
        for offset in (0..BLOCK_VOXELS).filter(|&offset| is_active(mask, offset)) {
            for (axis, stride) in [64, 8, 1].into_iter().enumerate() {
                let next = offset + stride;
                let ahead = local_of(offset)[axis] + 1 < BLOCK_EDGE && is_active(mask, next);
                if ahead && (values[offset] - values[next]).abs() > most {
                    steep.pairs += 1;
                    steep.first = steep.first.or(Some(voxel_of(*origin, offset)));
                }
            }
        }
        steep
    };
    let blocks = band.origins.par_iter().zip(band.distances.par_iter().zip(&band.active));
    Pairs::sum(&blocks.map(of_block).collect::<Vec<_>>())
}

/// Finds tears, places where the sign changes between neighbours that are both too far from any surface: a second
/// surface that no distance has, such as the inner shell of a solid that was not filled. Those are
/// neighbours of opposite sign whose distances add up to more than two voxels. Across a true surface
/// they add up to one at most.
pub fn tears(band: &Band) -> Pairs {
    let lookup = Lookup::new(band);
    let of_blocks = (0..band.origins.len()).into_par_iter().map(|block| block_tears(band, &lookup, block));
    let of_tiles = (0..band.inside_tiles.len()).into_par_iter().map(|tile| tile_tears(band, &lookup, tile));
    let found: Vec<Pairs> = of_blocks.chain(of_tiles).collect();
    Pairs::sum(&found)
}

fn block_tears(band: &Band, lookup: &Lookup<'_>, block: usize) -> Pairs {
    let around = lookup.around(block);
    let gap = 2.0 * band.lattice.voxel_size.get();
    let mut tears = Pairs::default();
    for (offset, &value) in band.distances[block].iter().enumerate() {
        let local = local_of(offset);
        for (step, ahead) in IVec3::AXES.into_iter().flat_map(|axis| [(axis, true), (-axis, false)]) {
            // A pair of block voxels is seen from both; it is counted once, looking ahead.
            if !ahead && matches!(around.at(local + step), Place::Voxel { .. }) {
                continue;
            }
            let other = around.value(local + step);
            let apart = (value >= 0.0) != (other >= 0.0);
            if apart && f64::from(value).abs() + f64::from(other).abs() > gap {
                tears.pairs += 1;
                tears.first = tears.first.or(Some(voxel_of(band.origins[block], offset)));
            }
        }
    }
    tears
}

/// Where a tile's faces look on nothing: neither on a block nor on another tile.
fn tile_tears(band: &Band, lookup: &Lookup<'_>, tile: usize) -> Pairs {
    let tile = band.inside_tiles[tile];
    let mut tears = Pairs::default();
    for axis in 0..3 {
        let (across, along) = (IVec3::AXES[(axis + 1) % 3] * BLOCK_EDGE, IVec3::AXES[(axis + 2) % 3] * BLOCK_EDGE);
        for beyond in [-1, tile.edge] {
            let face = tile.origin.saturating_add(IVec3::AXES[axis] * beyond);
            for row in 0..tile.edge / BLOCK_EDGE {
                for column in 0..tile.edge / BLOCK_EDGE {
                    let voxel = face + across * row + along * column;
                    if lookup.at(voxel) == Place::Outside {
                        tears.pairs += 1;
                        tears.first = tears.first.or(Some(voxel));
                    }
                }
            }
        }
    }
    tears
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::grid::testing::{band_of, sphere};

    #[test]
    fn a_distance_has_slope_one_and_no_tears() {
        let band = sphere(DVec3::new(0.1, 0.2, 0.3), 1.0, 0.04);
        let slope = slope_error(&band);
        assert!(slope.voxels > 10_000 && slope.mean < 1e-3 && slope.max < 2e-3, "{slope:?}");
        assert_eq!(tears(&band), Pairs::default());
        assert_eq!(steep_steps(&band), Pairs::default());
        let steep = steep_steps(&band_of(|p| 1.5 * (1.0 - p.length()), 1.3, 0.04));
        assert!(steep.pairs > 1000 && steep.first.is_some(), "{steep:?}");
        // Half as steep: half of the slope is missing.
        let flat = slope_error(&band_of(|p| 0.5 * (1.0 - p.length()), 1.3, 0.04));
        assert!((flat.mean - 0.5).abs() < 1e-3 && flat.off == flat.voxels && slope.off == 0, "{flat:?}");
    }

    #[test]
    fn an_unfilled_inside_is_a_tear() {
        let mut band = sphere(DVec3::ZERO, 1.0, 0.02);
        assert!(!band.inside_tiles.is_empty());
        let last = band.inside_tiles.pop().unwrap();
        let one = tears(&band);
        // A tile of a block's size has six faces: on other tiles one pair a face, on blocks 64.
        assert!(one.pairs >= 6, "{one:?}");
        assert!(one.first.is_some_and(|voxel| (voxel - last.origin).abs().max_element() <= 8));
        band.inside_tiles.clear();
        assert!(tears(&band).pairs > 64 * 100);
    }

    #[test]
    fn one_wrong_sign_is_a_tear() {
        let mut band = sphere(DVec3::ZERO, 1.0, 0.05);
        let deep = (0..BLOCK_VOXELS).find(|&offset| band.distances[0][offset] < -0.1).unwrap();
        band.distances[0][deep] *= -1.0;
        let found = tears(&band);
        assert!((1..=6).contains(&found.pairs), "{found:?}");
    }
}
