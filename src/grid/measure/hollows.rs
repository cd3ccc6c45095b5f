//! Hollows that are closed on all sides.

use glam::IVec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

use super::lookup::{Lookup, Place};
use super::pieces::Pieces;
use crate::grid::{BLOCK_EDGE, Band, InsideTile, block_order, node_origin};

/// The edge of the larger cubes that the outside is made of.
const NODE_EDGE: i32 = 128;

/// The volumes of the parts of space outside that nothing joins with what is around the solid, in cubic world units, the largest
/// first; whole voxels are counted. The outside is joined as the pieces of a solid are, by [`super::pieces`].
pub fn hollows(mut band: Band) -> Vec<f64> {
    let Some((tiles, around)) = outside(&band) else { return Vec::new() };
    band.inside_tiles = tiles;
    // What is neither stays inside alone.
    let turned = |distance: &mut f32| *distance = -distance.max(f32::MIN_POSITIVE).copysign(*distance);
    band.distances.par_iter_mut().flatten().for_each(turned);
    let pieces = Pieces::of(&band);
    let outer = pieces.of_tile(around);
    let mut volumes = pieces.volumes(&band);
    volumes.remove(outer);
    volumes
}

/// Cubes that make up all outside of the blocks of a band, somewhat beyond them, and the place of one that is around the solid;
/// `None` of a band without blocks, or one at the end of all numbers.
fn outside(band: &Band) -> Option<(Vec<InsideTile>, usize)> {
    let ends = |origin: IVec3, edge: i32| (origin, origin + (edge - 1));
    let blocks = band.origins.iter().map(|origin| ends(*origin, BLOCK_EDGE));
    let all = blocks.chain(band.inside_tiles.iter().map(|tile| ends(tile.origin, tile.edge)));
    let (low, high) = all.reduce(|(low, high), (from, to)| (low.min(from), high.max(to)))?;
    let low = node_origin(low, NODE_EDGE).checked_sub(IVec3::splat(NODE_EDGE))?;
    let high = node_origin(high, NODE_EDGE).checked_add(IVec3::splat(2 * NODE_EDGE))? - NODE_EDGE;
    let small = band.inside_tiles.iter().filter(|tile| tile.edge < NODE_EDGE).map(|tile| &tile.origin);
    let split: FxHashSet<IVec3> =
        band.origins.iter().chain(small).map(|origin| node_origin(*origin, NODE_EDGE)).collect();
    let lookup = Lookup::new(band);
    let mut tiles = Vec::new();
    let steps = |low: i32, high: i32| (low..=high).step_by(NODE_EDGE as usize);
    for x in steps(low.x, high.x) {
        for y in steps(low.y, high.y) {
            for z in steps(low.z, high.z) {
                let node = InsideTile { origin: IVec3::new(x, y, z), edge: NODE_EDGE };
                let is_outside = |origin: &IVec3| lookup.at(*origin) == Place::Outside;
                if split.contains(&node.origin) {
                    let blocks = node.blocks().filter(is_outside);
                    tiles.extend(blocks.map(|origin| InsideTile { origin, edge: BLOCK_EDGE }));
                } else if is_outside(&node.origin) {
                    tiles.push(node);
                }
            }
        }
    }
    tiles.sort_unstable_by_key(|tile| block_order(tile.origin));
    let around = tiles.iter().position(|tile| tile.origin == low)?;
    Some((tiles, around))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::grid::testing::band_of;

    fn ball(p: DVec3, centre: [f64; 3], radius: f64) -> f64 {
        radius - p.distance(DVec3::from(centre))
    }

    #[test]
    fn closed_hollows_are_counted_and_open_ones_are_not() {
        let solid = |p: DVec3| ball(p, [0.0; 3], 60.0);
        assert!(hollows(band_of(solid, 65.0, 1.0)).is_empty());
        // Deep enough for cubes without blocks in them.
        let shell = |p: DVec3| solid(p).min(-ball(p, [2.0, 0.0, 0.0], 50.0));
        let found = hollows(band_of(shell, 65.0, 1.0));
        let exact = 4.0 / 3.0 * std::f64::consts::PI * 50.0_f64.powi(3);
        assert!(found.len() == 1 && (found[0] / exact - 1.0).abs() < 0.01, "{found:?} for {exact}");
        // What floats in a hollow divides it not.
        assert_eq!(hollows(band_of(|p| shell(p).max(ball(p, [0.0; 3], 20.0)), 65.0, 1.0)).len(), 1);
        // A drain opens it.
        let drain = |p: DVec3| (p.truncate().length() - 3.0).max(-p.z);
        assert!(hollows(band_of(|p| shell(p).min(drain(p)), 65.0, 1.0)).is_empty());
    }

    /// Pores at places of a lattice: all within, but those that meet are one and those at the surface are open.
    #[test]
    fn pores_are_counted_one_by_one() {
        let pores: Vec<DVec3> = (0..64)
            .map(|i| DVec3::new(f64::from(i / 16), f64::from(i / 4 % 4), f64::from(i % 4)) * 14.0 - 21.0)
            .collect();
        let of = |radius: f64, half: f64| {
            let field = |p: DVec3| {
                let nearest = pores.iter().map(|pore| p.distance(*pore)).fold(f64::INFINITY, f64::min);
                (half - p.abs().max_element()).min(nearest - radius)
            };
            hollows(band_of(field, 40.0, 1.0)).len()
        };
        assert_eq!(of(5.0, 30.0), 64);
        assert_eq!(of(8.0, 34.0), 1);
        // Of 4³ those in the middle.
        assert_eq!(of(5.0, 21.0), 8);
    }
}
