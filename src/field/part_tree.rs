//! Which of very many parts is the best one at a point, by a tree of boxes: what [`super::parts`] asks where lists of
//! candidates grow long. A million parts answer as fast as a few hundred.
//!
//! Every part lies within a box grown by a radius, so its value is at most the radius minus the distance to the box. A
//! subtree whose bound is below the best value so far is left out. The answer is that of all parts, bit for bit.

use glam::DVec3;

use super::Aabb;
use super::part::{Parts, Sample};

/// Parts of a leaf. Fewer: more boxes are visited than parts; more: parts that cannot be the best are evaluated.
const LEAF: usize = 4;

/// Levels of a tree of `u32::MAX` parts, whose halves differ by one at most.
const DEEPEST: usize = 34;

/// Rounding of a bound, of its size: more than a part's value and its box can differ by.
const SLACK: f64 = 1e-12;

/// The tree.
pub struct PartTree {
    nodes: Vec<Node>,
    /// The parts in the order of leaves.
    order: Vec<u32>,
}

struct Node {
    min: DVec3,
    max: DVec3,
    radius: f64,
    /// Its parts in `order`.
    first: u32,
    count: u32,
    /// The second child; the first stands next to its parent. 0 in a leaf.
    second: u32,
}

impl Node {
    /// No part of it has a greater value.
    fn bound(&self, point: DVec3) -> f64 {
        let away = (self.min - point).max(point - self.max).max(DVec3::ZERO);
        let bound = self.radius - away.length();
        bound + SLACK * (bound.abs() + self.radius.abs() + point.abs().max_element())
    }
}

impl PartTree {
    /// Of all parts; `None` where one has no box.
    pub fn new(parts: &impl Parts) -> Option<Self> {
        let cores: Vec<(Aabb, f64)> = (0..parts.count()).map(|index| parts.core(index)).collect::<Option<_>>()?;
        let mut order: Vec<u32> = (0..cores.len() as u32).collect();
        let mut tree = Self { nodes: Vec::with_capacity(cores.len() / 2 + 1), order: Vec::new() };
        tree.grow(&cores, &mut order, 0);
        tree.order = order;
        Some(tree)
    }

    /// The node of some parts, which begin at `first` of all.
    fn grow(&mut self, cores: &[(Aabb, f64)], parts: &mut [u32], first: u32) {
        let whole = |parts: &[u32]| {
            let start = (DVec3::INFINITY, DVec3::NEG_INFINITY, f64::NEG_INFINITY);
            parts.iter().fold(start, |(min, max, radius), part| {
                let (bounds, own) = &cores[*part as usize];
                (min.min(bounds.min), max.max(bounds.max), radius.max(*own))
            })
        };
        let (min, max, radius) = whole(parts);
        let index = self.nodes.len();
        self.nodes.push(Node { min, max, radius, first, count: parts.len() as u32, second: 0 });
        if parts.len() <= LEAF {
            return;
        }
        let middle = |part: u32| cores[part as usize].0.centre();
        let spread = parts.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), part| {
            (min.min(middle(*part)), max.max(middle(*part)))
        });
        let axis = (spread.1 - spread.0).max_position();
        let half = parts.len() / 2;
        // The part's own number decides between equals: the same tree on every machine.
        parts.select_nth_unstable_by(half, |a, b| middle(*a)[axis].total_cmp(&middle(*b)[axis]).then(a.cmp(b)));
        let (low, high) = parts.split_at_mut(half);
        self.grow(cores, low, first);
        self.nodes[index].second = self.nodes.len() as u32;
        self.grow(cores, high, first + half as u32);
    }

    /// The best part at a point, the first where several are, and what it gives.
    pub fn best(&self, parts: &impl Parts, point: DVec3) -> (u32, Sample) {
        let mut best = (f64::NEG_INFINITY, DVec3::ZERO);
        let mut chosen = u32::MAX;
        self.visit(point, best.0, |part| {
            let sample = parts.part(part as usize, point);
            if sample.0 > best.0 || sample.0 == best.0 && part < chosen {
                (best, chosen) = (sample, part);
            }
            best.0
        });
        (chosen, best)
    }

    /// All parts whose value at a point may be `least` or more, the more promising before others. Each gives what that is from
    /// there on.
    #[inline]
    pub fn visit(&self, point: DVec3, mut least: f64, mut each: impl FnMut(u32) -> f64) {
        let mut open = [(0.0, 0); DEEPEST];
        let mut height = 1;
        open[0] = (self.nodes[0].bound(point), 0_u32);
        while height > 0 {
            height -= 1;
            let (bound, index) = open[height];
            if bound < least {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.second == 0 {
                for part in self.parts_of(node) {
                    least = each(*part);
                }
                continue;
            }
            let (one, two) = (index + 1, node.second);
            let one = (self.nodes[one as usize].bound(point), one);
            let two = (self.nodes[two as usize].bound(point), two);
            // The more promising one is looked at first.
            let (later, next) = if one.0 >= two.0 { (two, one) } else { (one, two) };
            (open[height], open[height + 1]) = (later, next);
            height += 2;
        }
    }

    /// All parts whose value at a point may be `least` or more, into `found`, in their own order; false where they are
    /// more than `most`.
    pub fn at_least(&self, parts: &impl Parts, point: DVec3, least: f64, most: usize, found: &mut Vec<u32>) -> bool {
        let mut open = [0_u32; DEEPEST];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let index = open[height];
            let node = &self.nodes[index as usize];
            if node.bound(point) < least {
                continue;
            }
            if node.second == 0 {
                let near = |part: &&u32| parts.part(**part as usize, point).0 >= least;
                found.extend(self.parts_of(node).iter().filter(near));
                if found.len() > most {
                    found.clear();
                    return false;
                }
                continue;
            }
            (open[height], open[height + 1]) = (node.second, index + 1);
            height += 2;
        }
        found.sort_unstable();
        true
    }

    fn parts_of(&self, node: &Node) -> &[u32] {
        &self.order[node.first as usize..(node.first + node.count) as usize]
    }
}
