//! The evaluator: which cell each point of a batch lies in, then the kernels.

use glam::DVec3;

use super::bricks::Grid;
use super::kernel::{self, Extent, Located};
use super::{DistanceObject, LEAF};
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points};

/// A node with its place, in smallest cells.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub node: u32,
    pub origin: [i32; 3],
    pub size: i32,
}

impl Place {
    /// A child by its number, the first child's node being `first`.
    pub(super) fn nth_child(self, first: u32, child: usize) -> Self {
        let size = self.size >> 1;
        let origin = std::array::from_fn(|axis| self.origin[axis] + if child & (4 >> axis) != 0 { size } else { 0 });
        Self { node: first + child as u32, origin, size }
    }

    /// Whether it holds a smallest cell.
    pub(super) fn holds(&self, at: [i32; 3]) -> bool {
        (0..3).all(|axis| at[axis] & -self.size == self.origin[axis])
    }

    /// The child that holds a smallest cell.
    #[inline]
    pub(super) fn child(self, first: u32, at: [i32; 3]) -> Self {
        let size = self.size >> 1;
        Self { node: first + child_at(at, size), origin: at.map(|at| at & -size), size }
    }
}

/// Which of a node's eight children, each of so many smallest cells along an edge, holds a smallest cell.
#[inline]
fn child_at(at: [i32; 3], size: i32) -> u32 {
    let [x, y, z] = at.map(|at| u32::from(at & size != 0));
    x << 2 | y << 1 | z
}

/// A region entered.
struct Region {
    within: Aabb,
    /// The innermost node that holds the part of the root nearest to it.
    place: Place,
    /// Whether the bricks around it have been looked for, and found.
    bricks: Option<bool>,
}

/// A batch of so many points is worth looking for the bricks around its region.
const WORTH_BRICKS: usize = 64;

pub(super) struct OctreeEvaluator<'a> {
    object: &'a DistanceObject,
    regions: Vec<Region>,
    /// By region, the innermost last; more than there are, for those to come.
    grids: Vec<Grid>,
    located: Box<Located>,
}

impl<'a> OctreeEvaluator<'a> {
    pub(super) fn new(object: &'a DistanceObject) -> Self {
        let located = Located {
            at: [[0.0; BATCH]; 3],
            cell: [[0; BATCH]; 3],
            t: [[0.0; BATCH]; 3],
            leaf: [0; BATCH],
            level: [0; BATCH],
            inverse_edge: [0.0; BATCH],
        };
        Self { object, regions: Vec::new(), grids: Vec::new(), located: Box::new(located) }
    }

    /// Finds the cells of a batch. Returns the leaf where it is one for all, and whether some points lie out of the
    /// root; those are given the nearest point of the root.
    fn locate(&mut self, points: &Points) -> (Option<Place>, bool) {
        let inverse_step = self.object.inverse_step;
        let offsets = [&points.x, &points.y, &points.z].map(|offsets| &offsets[..points.len]);
        let base = ((points.origin - self.object.origin) * inverse_step).to_array();
        let size = self.object.root_size() as i32;
        let Extent { low, high, outside } = kernel::place(offsets, base, inverse_step, size, &mut self.located);
        let around = self.around(low, high);
        if self.object.nodes[around.node as usize] & LEAF != 0 {
            kernel::place_in_cell(&mut self.located, around.origin, around.size, points.len);
            return (Some(around), outside);
        }
        if let Some(grid) = self.grid(points.len, low, high) {
            let Located { cell, leaf, level, .. } = &mut *self.located;
            self.grids[grid].leaves(&self.object.bricks, cell, leaf, level, points.len);
        } else {
            self.place_each(points.len, around);
        }
        kernel::place_in_leaves(&mut self.located, inverse_step, points.len);
        (None, outside)
    }

    /// The innermost node that holds all cells from `low` to `high`.
    fn around(&self, low: [i32; 3], high: [i32; 3]) -> Place {
        let holds = |place: &&Place| {
            (0..3).all(|axis| place.origin[axis] <= low[axis] && high[axis] < place.origin[axis] + place.size)
        };
        let mut places = self.regions.iter().rev().map(|region| &region.place);
        let mut around = places.find(holds).copied().unwrap_or(self.object.root());
        // Down while all go the same way.
        loop {
            let node = self.object.nodes[around.node as usize];
            let half = around.size >> 1;
            if node & LEAF != 0 || (0..3).any(|axis| (low[axis] ^ high[axis]) & half != 0) {
                return around;
            }
            around = around.child(node, low);
        }
    }

    /// The region whose bricks hold all cells from `low` to `high`. They are looked for where so many points are worth it.
    fn grid(&mut self, len: usize, low: [i32; 3], high: [i32; 3]) -> Option<usize> {
        let depth = self.regions.len();
        self.grids.resize_with(self.grids.len().max(depth), Grid::default);
        // Those of a large region serve many small ones in it.
        let grids = self.regions.iter_mut().zip(&mut self.grids).enumerate();
        for (which, (region, grid)) in grids {
            if region.bricks.is_none() && len >= WORTH_BRICKS {
                let (least, greatest) = self.object.cells_of(&region.within);
                region.bricks = Some(grid.find(self.object, region.place, least, greatest));
            }
            if region.bricks == Some(true) && grid.holds(low, high) {
                return Some(which);
            }
        }
        None
    }

    /// Finds the leaves one by one.
    fn place_each(&mut self, len: usize, start: Place) {
        let nodes = &self.object.nodes;
        let Located { cell, leaf, level: levels, .. } = &mut *self.located;
        let top = start.size.trailing_zeros() as usize;
        // The nodes around the cell before, by how often their edge doubles that of a smallest cell.
        let mut path = [start.node; i32::BITS as usize];
        // No cell is its own yet, so the first point looks one up.
        let (mut before, mut level) = ([-1; 3], 0);
        let mut this_leaf = 0;
        for i in 0..len.min(BATCH) {
            let here = [cell[0][i], cell[1][i], cell[2][i]];
            let apart = (here[0] ^ before[0]) | (here[1] ^ before[1]) | (here[2] ^ before[2]);
            let around = (i32::BITS - apart.leading_zeros()) as usize;
            // Points stand in rows: often the leaf is that of the point before, or not far up and down the tree.
            if around > level {
                level = around.min(top);
                let mut node = nodes[path[level] as usize];
                while node & LEAF == 0 {
                    level -= 1;
                    path[level] = node + child_at(here, 1 << level);
                    node = nodes[path[level] as usize];
                }
                before = here;
                this_leaf = node & !LEAF;
            }
            leaf[i] = this_leaf;
            levels[i] = level as u32;
        }
    }
}

impl Evaluator for OctreeEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        let from = self.regions.last().map_or(self.object.root(), |region| region.place);
        self.regions.push(Region { within: *region, place: self.object.node_around(region, from), bricks: None });
    }

    fn bounds(&mut self) -> Interval {
        let Some(region) = self.regions.last() else { return Interval::ALL };
        self.object.bounds_from(&region.within, region.place).value
    }

    fn hints(&mut self, asked: Hint) -> Hints {
        let region = self.regions.last().filter(|_| asked == Hint::Steepest && !self.object.jumps());
        let steepest = region.map(|region| self.object.steepest_from(&region.within, region.place));
        Hints { keeps_values: true, steepest, ..Hints::NONE }
    }

    fn leave(&mut self) {
        self.regions.pop();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        let (cell, outside) = self.locate(points);
        let object = self.object;
        let located = &self.located;
        match cell {
            Some(place) => {
                kernel::values_in_cell(object.polynomial(place), &located.t, out, points.len);
            }
            None => kernel::values(&object.polynomials, located, &mut out[..points.len]),
        }
        if outside {
            let mut last = None;
            for (i, out) in out.iter_mut().enumerate().take(points.len) {
                let position = points.position(i);
                if !object.holds(position) {
                    *out = object.beyond(position, &mut last)[0] as f32;
                }
            }
        }
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        let (cell, outside) = self.locate(points);
        let object = self.object;
        let located = &self.located;
        let len = points.len;
        match cell {
            Some(place) => {
                let Gradients { value, dx, dy, dz } = out;
                let inverse_edge = (object.inverse_step / f64::from(place.size)) as f32;
                kernel::gradients_in_cell(object.polynomial(place), inverse_edge, &located.t, [value, dx, dy, dz], len);
            }
            None => {
                let Gradients { value, dx, dy, dz } = out;
                kernel::gradients(&object.polynomials, located, [value, dx, dy, dz], len);
            }
        }
        if outside {
            let mut last = None;
            for i in 0..len {
                let position: DVec3 = points.position(i);
                if !object.holds(position) {
                    let [value, dx, dy, dz] = object.beyond(position, &mut last).map(|number| number as f32);
                    (out.value[i], out.dx[i], out.dy[i], out.dz[i]) = (value, dx, dy, dz);
                }
            }
        }
    }
}
