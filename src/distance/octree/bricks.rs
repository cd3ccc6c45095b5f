//! Which leaf holds each of many smallest cells, without a way down the tree for each: the leaves of small nodes as tables.

use super::evaluate::Place;
use super::tree::{Cell, Tree};
use super::{DistanceObject, LEAF};
use crate::field::BATCH;

/// The edge of a brick: a node, split, whose leaves stand in a table.
const EDGE: i32 = 1 << SHIFT;
const SHIFT: u32 = 3;
const CELLS: usize = (EDGE * EDGE * EDGE) as usize;

/// Bits of a table's entry below the leaf's place in the brick, for how often the leaf's edge doubles that of a smallest
/// cell.
const LEVEL_BITS: u32 = 2;

/// Most bricks of a [`Grid`].
const MOST: i32 = 1 << 10;

/// The tables of an octree.
#[derive(Clone, Debug, Default)]
pub(super) struct Bricks {
    /// By brick and by cell in it, x slowest: the leaf, counted from the brick's first, and its level. The first table is
    /// that of larger leaves: nothing is added to what is known of them.
    tables: Vec<[u16; CELLS]>,
    /// By brick.
    first_leaves: Vec<u32>,
    /// By family of eight children: the brick that they make up, where they do.
    by_family: Vec<u32>,
}

/// The brick or the leaf that holds a cell of a [`Grid`].
#[derive(Clone, Copy, Default)]
struct Holder {
    /// The leaf, or the brick's first.
    leaf: u32,
    /// That of the leaf; 0 for a brick.
    level: u32,
    /// The brick's table, or that of larger leaves.
    table: u32,
}

impl Holder {
    /// The leaf of an entry of its table, and how often its edge doubles that of a smallest cell.
    #[inline(always)]
    fn leaf(self, entry: u16) -> (u32, u32) {
        let entry = u32::from(entry);
        (self.leaf + (entry >> LEVEL_BITS), self.level + (entry & ((1 << LEVEL_BITS) - 1)))
    }
}

/// The bricks and larger leaves of a box of cells.
#[derive(Default)]
pub(super) struct Grid {
    /// The least brick, and the bricks along each axis.
    origin: [i32; 3],
    along: [i32; 3],
    holders: Vec<Holder>,
}

fn family(first_child: u32) -> usize {
    // The root comes first, then families of eight.
    (first_child as usize - 1) / 8
}

impl Bricks {
    /// Bytes that those of a tree take.
    pub fn bytes_of(tree: &Tree) -> usize {
        let split = |(cell, &children): (&Cell, &u32)| children != 0 && cell.size as i32 == EDGE;
        tree.cells.iter().zip(&tree.children).filter(|&node| split(node)).count() * (size_of::<[u16; CELLS]>() + 4)
            + tree.cells.len() / 2
    }

    /// The tables of finished nodes.
    pub fn new(nodes: &[u32], root_size: u32) -> Self {
        let by_family = vec![0; nodes.len() / 8];
        let mut bricks = Self { tables: vec![[0; CELLS]], first_leaves: vec![0], by_family };
        let mut open = vec![(0, root_size as i32)];
        while let Some((node, size)) = open.pop() {
            let first = nodes[node as usize];
            if first & LEAF != 0 {
                continue;
            }
            if size > EDGE {
                open.extend((0..8).map(|child| (first + child, size / 2)));
                continue;
            }
            bricks.by_family[family(first)] = bricks.tables.len() as u32;
            let mut table = [0; CELLS];
            // Leaves are numbered in the order of nodes, depth first.
            let first_leaf = first_leaf(nodes, node);
            fill(nodes, Place { node, origin: [0; 3], size }, first_leaf, &mut table);
            bricks.tables.push(table);
            bricks.first_leaves.push(first_leaf);
        }
        bricks
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.tables[..]) + size_of_val(&self.first_leaves[..]) + size_of_val(&self.by_family[..])
    }
}

fn first_leaf(nodes: &[u32], mut node: u32) -> u32 {
    while nodes[node as usize] & LEAF == 0 {
        node = nodes[node as usize];
    }
    nodes[node as usize] & !LEAF
}

/// Writes the leaves below a node into a brick's table.
fn fill(nodes: &[u32], place: Place, first_leaf: u32, table: &mut [u16; CELLS]) {
    let node = nodes[place.node as usize];
    if node & LEAF == 0 {
        (0..8).for_each(|child| fill(nodes, place.nth_child(node, child), first_leaf, table));
        return;
    }
    let entry = (((node & !LEAF) - first_leaf) << LEVEL_BITS | place.size.trailing_zeros()) as u16;
    let along = |axis: usize| place.origin[axis]..place.origin[axis] + place.size;
    for x in along(0) {
        for y in along(1) {
            for z in along(2) {
                table[in_table([x, y, z])] = entry;
            }
        }
    }
}

fn in_table(cell: [i32; 3]) -> usize {
    let [x, y, z] = cell.map(|at| at & (EDGE - 1));
    ((x * EDGE + y) * EDGE + z) as usize
}

/// Where a brick of a [`Grid`] stands among its holders, counted from the least, with so many along each axis.
fn in_grid([x, y, z]: [i32; 3], along: [i32; 3]) -> i32 {
    (x * along[1] + y) * along[2] + z
}

impl Grid {
    /// Finds the bricks around all cells from `low` to `high` that lie in the node `from`. `false` where they are too many.
    pub fn find(&mut self, object: &DistanceObject, from: Place, low: [i32; 3], high: [i32; 3]) -> bool {
        // A brick is known whole or not at all.
        let from = if from.size < EDGE { object.root() } else { from };
        let high: [i32; 3] = std::array::from_fn(|axis| high[axis].min(from.origin[axis] + from.size - 1));
        self.origin = low.map(|cell| cell >> SHIFT);
        self.along = std::array::from_fn(|axis| (high[axis] >> SHIFT) - self.origin[axis] + 1);
        let count = self.along.iter().try_fold(1_i32, |all, &along| all.checked_mul(along));
        let Some(count) = count.filter(|&count| count <= MOST) else { return false };
        self.holders.clear();
        self.holders.resize(count as usize, Holder::default());
        self.visit(object, from);
        true
    }

    fn visit(&mut self, object: &DistanceObject, place: Place) {
        // The bricks of the grid that the node fills, or the one that it lies in.
        let mut ranges = [0..0, 0..0, 0..0];
        for axis in 0..3 {
            let first = (place.origin[axis] >> SHIFT) - self.origin[axis];
            let end = first + (place.size >> SHIFT).max(1);
            ranges[axis] = first.max(0)..end.min(self.along[axis]);
            if ranges[axis].is_empty() {
                return;
            }
        }
        let node = object.nodes[place.node as usize];
        let holder = if node & LEAF != 0 {
            Holder { leaf: node & !LEAF, level: place.size.trailing_zeros(), table: 0 }
        } else if place.size <= EDGE {
            let table = object.bricks.by_family[family(node)];
            Holder { leaf: object.bricks.first_leaves[table as usize], level: 0, table }
        } else {
            (0..8).for_each(|child| self.visit(object, place.nth_child(node, child)));
            return;
        };
        let [x, y, z] = ranges;
        for x in x {
            for y in y.clone() {
                let row = in_grid([x, y, 0], self.along) as usize;
                self.holders[row + z.start as usize..row + z.end as usize].fill(holder);
            }
        }
    }

    /// Whether all cells from `low` to `high` are in bricks that were found.
    pub fn holds(&self, low: [i32; 3], high: [i32; 3]) -> bool {
        (0..3).all(|axis| {
            self.origin[axis] <= (low[axis] >> SHIFT) && (high[axis] >> SHIFT) < self.origin[axis] + self.along[axis]
        })
    }

    /// The leaf of each of so many cells, and how often its edge doubles that of a smallest cell.
    pub fn leaves(
        &self,
        bricks: &Bricks,
        cells: &[[i32; BATCH]; 3],
        leaf: &mut [u32; BATCH],
        level: &mut [u32; BATCH],
        len: usize,
    ) {
        // Where to look is worked out for many at a time, and stands where the answers will.
        places(cells, self.origin, self.along, leaf, level, len);
        for (leaf, level) in leaf.iter_mut().zip(level).take(len) {
            let holder = self.holders[*leaf as usize];
            (*leaf, *level) = holder.leaf(bricks.tables[holder.table as usize][*level as usize]);
        }
    }
}

/// Where the holder of each of so many cells stands in a [`Grid`], and the cell in a brick's table.
#[multiversion::multiversion(targets = "simd")]
fn places(
    [x, y, z]: &[[i32; BATCH]; 3],
    origin: [i32; 3],
    along: [i32; 3],
    holders: &mut [u32; BATCH],
    entries: &mut [u32; BATCH],
    len: usize,
) {
    for i in 0..len.min(BATCH) {
        let brick = [(x[i] >> SHIFT) - origin[0], (y[i] >> SHIFT) - origin[1], (z[i] >> SHIFT) - origin[2]];
        holders[i] = in_grid(brick, along) as u32;
        entries[i] = in_table([x[i], y[i], z[i]]) as u32;
    }
}
