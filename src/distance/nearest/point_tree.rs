//! Points in space and which of them is the nearest: a k-d tree that is the same on any machine.

use glam::DVec3;

/// Points in a leaf. Fewer makes the tree deeper, more makes leaves slow.
const LEAF: usize = 8;

/// A k-d tree over points, stored in the order of its leaves.
pub struct PointTree {
    points: Vec<DVec3>,
    /// In depth-first order: the lower half's nodes start right after a node.
    nodes: Vec<Node>,
}

struct Node {
    /// The box around its points: points of a surface fill little of the space between the cuts.
    least: DVec3,
    greatest: DVec3,
    /// Where the upper half's nodes start.
    upper: u32,
}

impl Node {
    fn distance_squared(&self, position: DVec3) -> f64 {
        (self.least - position).max(position - self.greatest).max(DVec3::ZERO).length_squared()
    }
}

impl PointTree {
    /// Sorts the points into a tree.
    pub fn new(mut points: Vec<DVec3>) -> Self {
        let mut nodes = Vec::with_capacity(4 * points.len() / LEAF);
        build(&mut points, &mut nodes);
        Self { points, nodes }
    }

    /// How many points there are.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// The nearest point and its number, which a later call for a position nearby may be given to start from.
    pub fn nearest(&self, position: DVec3, start: Option<usize>) -> Option<(usize, DVec3)> {
        let first = start.unwrap_or(0);
        let mut best = (self.points.get(first)?.distance_squared(position), first);
        self.search(position, 0, 0, self.points.len(), &mut best);
        Some((best.1, self.points[best.1]))
    }

    /// Looks through the points `from..to` of a node.
    fn search(&self, p: DVec3, node: usize, from: usize, to: usize, best: &mut (f64, usize)) {
        if to - from <= LEAF {
            for (i, point) in self.points[from..to].iter().enumerate() {
                let found = (point.distance_squared(p), from + i);
                // Of equally near points the first, whatever the search started from.
                if found < *best {
                    *best = found;
                }
            }
            return;
        }
        let middle = from + (to - from) / 2;
        let half = |node: usize, from, to| (self.nodes[node].distance_squared(p), node, from, to);
        let mut halves = [half(node + 1, from, middle), half(self.nodes[node].upper as usize, middle, to)];
        if halves[1].0 < halves[0].0 {
            halves.swap(0, 1);
        }
        for (distance, node, from, to) in halves {
            if distance <= best.0 {
                self.search(p, node, from, to, best);
            }
        }
    }
}

fn build(points: &mut [DVec3], nodes: &mut Vec<Node>) {
    let least = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let greatest = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let node = nodes.len();
    nodes.push(Node { least, greatest, upper: 0 });
    if points.len() <= LEAF {
        return;
    }
    let size = greatest - least;
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let middle = points.len() / 2;
    // Ties are settled by the other axes, so that the order does not hang on how a selection works.
    let order = |a: &DVec3, b: &DVec3| {
        let by = |axis: usize| a[axis % 3].total_cmp(&b[axis % 3]);
        by(axis).then_with(|| by(axis + 1)).then_with(|| by(axis + 2))
    };
    points.select_nth_unstable_by(middle, order);
    let (lower, upper) = points.split_at_mut(middle);
    build(lower, nodes);
    nodes[node].upper = nodes.len() as u32;
    build(upper, nodes);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_is_that_of_a_plain_search() {
        let mut state = 1_u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        // Coarse coordinates, to have ties and points that fall together.
        let points: Vec<DVec3> = (0..500).map(|_| (DVec3::new(unit(), unit(), unit()) * 8.0).floor()).collect();
        let tree = PointTree::new(points);
        let mut last = None;
        for _ in 0..500 {
            let p = DVec3::new(unit(), unit(), unit()) * 12.0 - 2.0;
            let (index, point) = tree.nearest(p, last).expect("there are points");
            let least = tree.points.iter().map(|q| q.distance_squared(p)).fold(f64::INFINITY, f64::min);
            assert_eq!(point.distance_squared(p), least);
            assert_eq!(tree.nearest(p, None), Some((index, point)));
            last = Some(index);
        }
        assert!(PointTree::new(Vec::new()).nearest(DVec3::ZERO, None).is_none());
    }
}
