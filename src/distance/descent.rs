//! From a root box down to the leaf blocks that may hold a piece of the band.
//!
//! A node is judged by bounds of F over the box around its voxel centres grown by the half width: where no zero can
//! lie there, no voxel of the node is in the band. Only *maybe* nodes are opened, halving the edge each time; pruning
//! nests, so that a leaf's tape holds only what matters near it. Conservative: a block that holds a piece of the band
//! is never dropped.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::IVec3;
use rayon::prelude::*;

use super::polish::Resolution;
use crate::{
    field::{Aabb, BATCH, Evaluator, Field, Hint, Interval, Points, Slope},
    grid::{BLOCK_EDGE, InsideTile, Lattice, block_order, node_origin},
};

/// Edge of the nodes that tasks are made of, in voxels.
pub const NODE_EDGE: i32 = 128;
const ROOT_EDGE: i32 = 4096;

/// Where to look for the band.
#[derive(Clone, Copy, Debug)]
pub struct Scope {
    /// Where the voxels stand.
    pub lattice: Lattice,
    /// Half the band's width in voxels.
    pub half_width: f32,
    /// Only blocks with a voxel centre in this box are looked at.
    pub region: Aabb,
}

impl Scope {
    /// The least block corner and the end of the greatest block that have voxel centres in the region.
    pub fn block_range(&self) -> [IVec3; 2] {
        let edge = self.lattice.voxel_size.get();
        let least = (self.region.min / edge).ceil().as_ivec3();
        let greatest = (self.region.max / edge).floor().as_ivec3();
        let mask = IVec3::splat(!(BLOCK_EDGE - 1));
        [least & mask, (greatest & mask) + BLOCK_EDGE]
    }

    /// The distance at which the band ends, world units.
    pub fn background(&self) -> f32 {
        (f64::from(self.half_width) * self.lattice.voxel_size.get()) as f32
    }

    /// What F resolves over the region.
    pub fn resolution(&self) -> Resolution {
        Resolution::new(self.lattice.voxel_size.get(), self.region.size().max_element())
    }

    /// The box around the voxel centres of a node, grown by `margin` voxels.
    pub fn centres(&self, origin: IVec3, edge: i32, margin: f64) -> Aabb {
        let size = self.lattice.voxel_size.get();
        let least = origin.as_dvec3() - margin;
        let greatest = (origin + (edge - 1)).as_dvec3() + margin;
        Aabb::new(least * size, greatest * size)
    }
}

/// What a descent found.
#[derive(Clone, Debug, Default)]
pub struct Descent {
    /// Least corners of the blocks that may hold a piece of the band, in [`block_order`].
    pub blocks: Vec<IVec3>,
    /// Nodes wholly inside the solid and out of the band's reach, in [`block_order`].
    pub inside_tiles: Vec<InsideTile>,
}

impl Descent {
    fn append(&mut self, mut other: Self) {
        self.blocks.append(&mut other.blocks);
        self.inside_tiles.append(&mut other.inside_tiles);
    }

    fn sort(&mut self) {
        self.blocks.sort_unstable_by_key(|&origin| block_order(origin));
        self.inside_tiles.sort_unstable_by_key(|tile| block_order(tile.origin));
    }
}

/// Finds all blocks of a scope that may hold a piece of the band; `None` when cancelled.
pub fn descend(field: &dyn Field, scope: &Scope, cancel: &AtomicBool) -> Option<Descent> {
    let mut upper = Walk::new(field, scope, NODE_EDGE, cancel);
    upper.roots();
    // In the order of blocks, so that what the nodes hold comes in that order too.
    upper.found.sort();
    let parts: Vec<Descent> = upper
        .found
        .blocks
        .par_iter()
        .with_max_len(1)
        .map_init(
            || Walk::new(field, scope, BLOCK_EDGE, cancel),
            |walk, &node| {
                walk.open(node, NODE_EDGE);
                walk.drop_far_blocks(node);
                walk.found.sort();
                std::mem::take(&mut walk.found)
            },
        )
        .collect();
    if cancel.load(Ordering::Relaxed) {
        return None;
    }
    let mut all = Descent { blocks: Vec::new(), inside_tiles: upper.found.inside_tiles };
    all.blocks.reserve_exact(parts.iter().map(|part| part.blocks.len()).sum());
    parts.into_iter().for_each(|part| all.append(part));
    // Two sorted lists in a row: those of whole nodes, and those within.
    all.inside_tiles.sort_by_key(|tile| block_order(tile.origin));
    Some(all)
}

/// One thread's walk down to nodes of edge `least`.
struct Walk<'a> {
    evaluator: Box<dyn Evaluator + 'a>,
    slope: Slope,
    scope: &'a Scope,
    range: [IVec3; 2],
    least: i32,
    cancel: &'a AtomicBool,
    found: Descent,
}

impl<'a> Walk<'a> {
    fn new(field: &'a dyn Field, scope: &'a Scope, least: i32, cancel: &'a AtomicBool) -> Self {
        let (evaluator, slope, range) = (field.evaluator(), field.slope(), scope.block_range());
        Self { evaluator, slope, scope, range, least, cancel, found: Descent::default() }
    }

    /// Walks all root nodes that meet the range.
    fn roots(&mut self) {
        let [least, end] = self.range;
        let first = node_origin(least, ROOT_EDGE);
        for x in (first.x..end.x).step_by(ROOT_EDGE as usize) {
            for y in (first.y..end.y).step_by(ROOT_EDGE as usize) {
                for z in (first.z..end.z).step_by(ROOT_EDGE as usize) {
                    self.judge(IVec3::new(x, y, z), ROOT_EDGE);
                }
            }
        }
    }

    /// Bounds F over a node; opens it, lists it or drops it.
    fn judge(&mut self, origin: IVec3, edge: i32) {
        let [least, end] = self.range;
        let outside = origin.cmpge(end).any() || (origin + edge).cmple(least).any();
        if outside || self.cancel.load(Ordering::Relaxed) {
            return;
        }
        let region = self.scope.centres(origin, edge, f64::from(self.scope.half_width));
        self.evaluator.enter(&region);
        let vanishes = self.evaluator.hints(Hint::Vanishes).vanishes;
        let bounds = if vanishes { Interval::ALL } else { self.evaluator.bounds() };
        if bounds.lo > 0.0 {
            self.tile(origin, edge);
        } else if bounds.hi >= 0.0 {
            if edge == self.least {
                self.found.blocks.push(origin);
            } else {
                self.children(origin, edge);
            }
        }
        self.evaluator.leave();
    }

    /// Enters a node that is known to be opened and walks its children.
    fn open(&mut self, origin: IVec3, edge: i32) {
        self.evaluator.enter(&self.scope.centres(origin, edge, f64::from(self.scope.half_width)));
        self.children(origin, edge);
        self.evaluator.leave();
    }

    fn children(&mut self, origin: IVec3, edge: i32) {
        let half = edge / 2;
        for child in 0..8 {
            self.judge(origin + IVec3::new(child >> 2, (child >> 1) & 1, child & 1) * half, half);
        }
    }

    /// Lists an inside node as the tiles of OpenVDB's sizes that make it up, those in the range only.
    fn tile(&mut self, origin: IVec3, edge: i32) {
        let [least, end] = self.range;
        let whole = origin.cmpge(least).all() && (origin + edge).cmple(end).all();
        if whole && [ROOT_EDGE, NODE_EDGE, BLOCK_EDGE].contains(&edge) {
            self.found.inside_tiles.push(InsideTile { origin, edge });
            return;
        }
        let half = edge / 2;
        for child in 0..8 {
            let child = origin + IVec3::new(child >> 2, (child >> 1) & 1, child & 1) * half;
            if child.cmplt(end).all() && (child + half).cmpgt(least).all() {
                self.tile(child, half);
            }
        }
    }

    /// Where the field declares its slope, its value in a block's middle says how near the surface can be.
    fn drop_far_blocks(&mut self, node: IVec3) {
        let slope = match self.slope {
            Slope::Exact { .. } => 1.0,
            Slope::Lipschitz(slope) => slope,
            Slope::Unknown => return,
        };
        let size = self.scope.lattice.voxel_size.get();
        let half = f64::from(BLOCK_EDGE - 1) / 2.0;
        // The rounding of an f32 value is far below a thousandth.
        let far = slope * size * (half * 3f64.sqrt() + f64::from(self.scope.half_width)) * 1.001;
        self.evaluator.enter(&self.scope.centres(node, NODE_EDGE, f64::from(self.scope.half_width)));
        let blocks = std::mem::take(&mut self.found.blocks);
        let mut points = Points::new((node.as_dvec3() + f64::from(NODE_EDGE / 2)) * size);
        let mut values = [0.0; BATCH];
        for run in blocks.chunks(BATCH) {
            points.len = 0;
            for block in run {
                points.push(((block.as_dvec3() + half) * size - points.origin).as_vec3());
            }
            self.evaluator.values(&points, &mut values);
            for (&block, &value) in run.iter().zip(&values) {
                let value = f64::from(value);
                if value > far {
                    self.found.inside_tiles.push(InsideTile { origin: block, edge: BLOCK_EDGE });
                } else if value.is_nan() || value >= -far {
                    self.found.blocks.push(block);
                }
            }
        }
        self.evaluator.leave();
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::{
        distance::{
            accuracy::exact,
            testing::{Joined, Leaf},
        },
        grid::VoxelSize,
    };

    fn scope(size: f64) -> Scope {
        let lattice = Lattice { voxel_size: VoxelSize::new(size).unwrap() };
        Scope { lattice, half_width: 3.0, region: Aabb::new(DVec3::splat(-1.2), DVec3::splat(1.2)) }
    }

    /// Judges every block of the range by the exact distance of its voxels.
    fn check(field: &Joined, scope: &Scope, truth: impl Fn(DVec3) -> f64) -> f64 {
        let found = descend(field, scope, &AtomicBool::new(false)).unwrap();
        assert!(found.blocks.is_sorted_by_key(|&origin| block_order(origin)));
        let in_tile = |p: IVec3| {
            found.inside_tiles.iter().any(|tile| p.cmpge(tile.origin).all() && p.cmplt(tile.origin + tile.edge).all())
        };
        let [least, end] = scope.block_range();
        let background = 3.0 * scope.lattice.voxel_size.get();
        let mut needed = 0;
        for x in (least.x..end.x).step_by(8) {
            for y in (least.y..end.y).step_by(8) {
                for z in (least.z..end.z).step_by(8) {
                    let block = IVec3::new(x, y, z);
                    let points = Points::of_block(block, &scope.lattice);
                    let distances = (0..BATCH).map(|i| truth(points.position(i)));
                    let holds_band = distances.into_iter().any(|distance| distance.abs() < background);
                    let opened = found.blocks.contains(&block);
                    assert!(opened || !holds_band, "{block} holds a piece of the band");
                    needed += i32::from(holds_band);
                    if !opened {
                        assert_eq!(in_tile(block), truth(points.origin) > 0.0, "{block}");
                    }
                }
            }
        }
        found.blocks.len() as f64 / f64::from(needed)
    }

    #[test]
    fn blocks_of_a_sphere_are_all_found_and_few_are_spare() {
        let field = Joined::one(Leaf::Sphere(DVec3::splat(0.01), 1.0));
        let ratio = check(&field, &scope(1.0 / 64.0), |p| exact::sphere(p, DVec3::splat(0.01), 1.0));
        assert!(ratio < 1.25, "{ratio}");
    }

    #[test]
    fn a_large_solid_becomes_tiles_clipped_to_the_region() {
        let field = Joined::one(Leaf::Sphere(DVec3::ZERO, 50.0));
        let found = descend(&field, &scope(1.0 / 256.0), &AtomicBool::new(false)).unwrap();
        assert!(found.blocks.is_empty());
        let volume: i64 = found.inside_tiles.iter().map(|tile| i64::from(tile.edge).pow(3)).sum();
        let [least, end] = scope(1.0 / 256.0).block_range();
        let size = (end - least).as_i64vec3();
        assert_eq!(volume, size.x * size.y * size.z);
        assert!(found.inside_tiles.iter().any(|tile| tile.edge == 128));
    }
}
