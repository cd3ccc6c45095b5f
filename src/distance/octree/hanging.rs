//! Which corners hang, and on which leaf: those of cells half as large, in the middles of its faces and edges.
//!
//! Found from the split nodes, with the nodes of their size around them: a corner hangs where a node that has it among its
//! middles is split, and another is a leaf. Nodes that touch differ by no more than one halving, so no larger leaf has it.

use rayon::prelude::*;

use super::LEAF;
use super::refine::middles;
use super::tree::{NONE, halves_of, point_at};

/// A corner that hangs.
#[derive(Clone, Copy, Debug)]
pub struct Hanging {
    /// The first of the leaves that it hangs on.
    pub leaf: u32,
    /// Where on it, in halves of its edge.
    pub halves: [u32; 3],
    /// The corner's number.
    pub corner: u32,
}

/// A node with those of its size around it, by the step there, x slowest: [`NONE`] out of the root and where there is none
/// so small.
#[derive(Clone, Copy)]
struct Around {
    nodes: [u32; 27],
    /// How often its edge halves the root's.
    depth: usize,
}

/// Where the node itself is among those around it.
const SELF: usize = 13;

/// Split nodes of the same size whose parts are walked at the same time: enough for many threads.
const ENOUGH: usize = 4096;

struct Walk<'a> {
    nodes: &'a [u32],
    leaves: &'a [[u32; 8]],
    /// The middles of a cell in halves of its edge, and where the nodes are that have them too.
    middles: Vec<([u32; 3], Vec<usize>)>,
}

impl<'a> Walk<'a> {
    fn new(nodes: &'a [u32], leaves: &'a [[u32; 8]]) -> Self {
        let others = |halves: [u32; 3]| {
            // Each step over a face that the point lies on, and all of them together.
            let meets = |&at: &usize| {
                at != SELF && halves_of(at).iter().zip(halves).all(|(&step, half)| step == 1 || step == half)
            };
            (0..27).filter(meets).collect()
        };
        Self { nodes, leaves, middles: middles().map(|halves| (halves, others(halves))).collect() }
    }

    fn is_split(&self, node: u32) -> bool {
        node != NONE && self.nodes[node as usize] & LEAF == 0
    }

    /// A child of a node, with what is around it.
    fn child(&self, around: &Around, child: usize) -> Around {
        let mut nodes = [NONE; 27];
        let bit = |axis: usize| child as u32 >> (2 - axis) & 1;
        for (i, node) in nodes.iter_mut().enumerate() {
            let step = halves_of(i);
            // In children, counted from two below the node: 1 is one below it, 2 and 3 are its own, 4 is above.
            let at: [u32; 3] = std::array::from_fn(|axis| bit(axis) + step[axis] + 1);
            let parent = around.nodes[point_at(at.map(|at| at / 2))];
            if self.is_split(parent) {
                *node = self.nodes[parent as usize] + ((at[0] & 1) << 2 | (at[1] & 1) << 1 | at[2] & 1);
            }
        }
        Around { nodes, depth: around.depth + 1 }
    }

    /// A corner of a node: that of all its children there.
    fn corner(&self, mut node: u32, corner: usize) -> u32 {
        while self.nodes[node as usize] & LEAF == 0 {
            node = self.nodes[node as usize] + corner as u32;
        }
        self.leaves[(self.nodes[node as usize] & !LEAF) as usize][corner]
    }

    /// The corners in a split node's middles that hang.
    fn at(&self, around: &Around, found: &mut [Vec<Hanging>]) {
        let own = around.nodes[SELF];
        for (halves, others) in &self.middles {
            let (mut leaf, mut other, mut first) = (NONE, SELF, true);
            for &at in others {
                let node = around.nodes[at];
                if node == NONE {
                    continue;
                }
                let what = self.nodes[node as usize];
                if what & LEAF == 0 {
                    // Told once, by the first of those that are split.
                    first &= own < node;
                } else if what & !LEAF < leaf {
                    (leaf, other) = (what & !LEAF, at);
                }
            }
            if leaf == NONE || !first {
                continue;
            }
            let step = halves_of(other);
            let there = std::array::from_fn(|axis| halves[axis] + 2 - 2 * step[axis]);
            let bit = |of: fn(u32) -> u32| halves.iter().fold(0, |bits, half| bits << 1 | of(*half) as usize);
            let (child, corner) = (bit(|half| half / 2), bit(|half| half - half / 2));
            let corner = self.corner(self.nodes[own as usize] + child as u32, corner);
            found[around.depth].push(Hanging { leaf, halves: there, corner });
        }
    }

    fn below(&self, around: &Around, found: &mut Vec<Vec<Hanging>>) {
        found.resize_with(found.len().max(around.depth + 1), Vec::new);
        self.at(around, found);
        for child in 0..8 {
            if self.is_split(self.nodes[around.nodes[SELF] as usize] + child as u32) {
                self.below(&self.child(around, child), found);
            }
        }
    }
}

/// All corners that hang, by how often the edge of the leaf that they hang on halves the root's.
pub fn hanging(nodes: &[u32], leaves: &[[u32; 8]]) -> Vec<Vec<Hanging>> {
    let walk = Walk::new(nodes, leaves);
    let mut root = Around { nodes: [NONE; 27], depth: 0 };
    root.nodes[SELF] = 0;
    let mut found = vec![Vec::new()];
    let mut open: Vec<Around> = walk.is_split(0).then_some(root).into_iter().collect();
    while !open.is_empty() && open.len() < ENOUGH {
        let mut next = Vec::new();
        for around in &open {
            found.resize_with(found.len().max(around.depth + 1), Vec::new);
            walk.at(around, &mut found);
            let children = (0..8).map(|child| walk.child(around, child));
            next.extend(children.filter(|child| walk.is_split(child.nodes[SELF])));
        }
        open = next;
    }
    let parts: Vec<Vec<Vec<Hanging>>> = open
        .par_chunks(64)
        .map(|some| {
            let mut found = Vec::new();
            some.iter().for_each(|around| walk.below(around, &mut found));
            found
        })
        .collect();
    for part in parts {
        found.resize_with(found.len().max(part.len()), Vec::new);
        found.iter_mut().zip(part).for_each(|(all, some)| all.extend(some));
    }
    found
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::super::flatten;
    use super::super::tree::{Cell, Tree};
    use super::*;

    /// Split here and there, and balanced.
    fn tree(depth: u32, mut state: u64) -> Tree {
        let mut tree = Tree::new(1 << depth);
        let mut open = vec![0];
        while let Some(node) = open.pop() {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let whole = tree.cells[node as usize].size > 1 << (depth - 2);
            if tree.cells[node as usize].size > 1 && (whole || state >> 61 < 3) {
                let first = tree.split(node);
                open.extend(first..first + 8);
            }
        }
        let all = 0..tree.cells.len() as u32;
        let split: Vec<u32> = all.filter(|&node| tree.children[node as usize] != 0).collect();
        tree.balance(split);
        tree
    }

    /// By looking at every middle of every leaf whether some leaf has a corner there.
    #[test]
    fn corners_hang_on_the_first_leaf_that_has_them_in_a_middle() {
        for seed in 0..6 {
            let tree = tree(6, seed);
            let (nodes, order) = flatten(&tree);
            let cells: Vec<Cell> = order.iter().map(|&node| tree.cells[node as usize]).collect();
            let mut numbers = HashMap::new();
            let mut number = |place| {
                let next = numbers.len() as u32;
                *numbers.entry(place).or_insert(next)
            };
            let leaves: Vec<[u32; 8]> =
                cells.iter().map(|cell| std::array::from_fn(|corner| number(cell.corner(corner)))).collect();
            let mut expected = HashMap::new();
            for (leaf, cell) in cells.iter().enumerate().filter(|(_, cell)| cell.size > 1) {
                for halves in middles() {
                    if let Some(corner) = numbers.get(&cell.point(halves)) {
                        expected.entry(*corner).or_insert((leaf as u32, halves));
                    }
                }
            }
            let found = hanging(&nodes, &leaves);
            for (depth, some) in found.iter().enumerate() {
                for Hanging { leaf, halves, corner } in some {
                    assert_eq!(cells[*leaf as usize].size, 64 >> depth);
                    assert_eq!(expected.remove(corner), Some((*leaf, *halves)), "corner {corner}");
                }
            }
            assert!(expected.is_empty(), "{expected:?}");
            assert!(found.iter().map(Vec::len).sum::<usize>() > 1000);
        }
    }
}
