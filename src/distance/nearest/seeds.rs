//! Points in space and which of them is the nearest: a k-d tree that is the same on any machine.

use glam::DVec3;

/// Points in a leaf. Fewer makes the tree deeper, more makes leaves slow.
const LEAF: usize = 8;

/// A k-d tree over points, stored in the order of its leaves.
pub struct SeedTree {
    points: Vec<DVec3>,
    /// Inner nodes in depth-first order: the axis and place of the cut, and where the upper half's nodes start. The
    /// lower half's start right after the node.
    nodes: Vec<Node>,
}

struct Node {
    axis: u8,
    cut: f64,
    upper: u32,
}

impl SeedTree {
    /// Sorts the points into a tree.
    pub fn new(mut points: Vec<DVec3>) -> Self {
        let mut nodes = Vec::with_capacity(2 * points.len() / LEAF);
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
        self.search(position, 0, 0, self.points.len(), DVec3::ZERO, &mut best);
        Some((best.1, self.points[best.1]))
    }

    /// `gap`: how far the position is from the node's box along each axis, as far as the cuts above tell.
    fn search(&self, p: DVec3, node: usize, from: usize, to: usize, gap: DVec3, best: &mut (f64, usize)) {
        if to - from <= LEAF {
            for i in from..to {
                let distance = self.points[i].distance_squared(p);
                // Of equally near points the first, whatever the search started from.
                if distance < best.0 || distance == best.0 && i < best.1 {
                    *best = (distance, i);
                }
            }
            return;
        }
        let middle = from + (to - from) / 2;
        let Node { axis, cut, upper } = self.nodes[node];
        let side = p[usize::from(axis)] - cut;
        let mut far_gap = gap;
        far_gap[usize::from(axis)] = side;
        let lower = (node + 1, from, middle);
        let upper = (upper as usize, middle, to);
        let (near, far) = if side < 0.0 { (lower, upper) } else { (upper, lower) };
        self.search(p, near.0, near.1, near.2, gap, best);
        if far_gap.length_squared() <= best.0 {
            self.search(p, far.0, far.1, far.2, far_gap, best);
        }
    }
}

fn build(points: &mut [DVec3], nodes: &mut Vec<Node>) {
    if points.len() <= LEAF {
        return;
    }
    let least = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let greatest = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
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
    let node = nodes.len();
    nodes.push(Node { axis: axis as u8, cut: points[middle][axis], upper: 0 });
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
        let tree = SeedTree::new(points);
        let mut last = None;
        for _ in 0..500 {
            let p = DVec3::new(unit(), unit(), unit()) * 12.0 - 2.0;
            let (index, point) = tree.nearest(p, last).expect("there are points");
            let least = tree.points.iter().map(|q| q.distance_squared(p)).fold(f64::INFINITY, f64::min);
            assert_eq!(point.distance_squared(p), least);
            assert_eq!(tree.nearest(p, None), Some((index, point)));
            last = Some(index);
        }
        assert!(SeedTree::new(Vec::new()).nearest(DVec3::ZERO, None).is_none());
    }
}
