//! Points in space and which of them is the nearest: a k-d tree that is the same on any machine.

use std::hint::select_unpredictable;

use glam::DVec3;

use crate::distance::polish::around::box_of;
use crate::field::Aabb;

/// Looking at so many points one after the other, for many positions at once, takes less time than searches of the tree.
const MOST_IN_TURN: usize = 256;

/// Positions looked at together: few enough for what is known of them to stay in registers.
const LANES: usize = 8;

/// Points in a leaf. Fewer makes the tree deeper, more makes leaves slow.
const LEAF: usize = 8;

/// A k-d tree over points, stored in the order of its leaves.
pub struct PointTree {
    points: Vec<DVec3>,
    /// In depth-first order: the lower half's nodes start right after a node.
    nodes: Vec<Node>,
}

#[derive(Clone, Copy)]
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

/// What may be the nearest to some position of a region.
struct Near {
    region: Aabb,
    /// No position of the region is farther than this, squared, from some point.
    within: f64,
    /// Some are beyond it by now.
    points: Vec<usize>,
}

impl Near {
    /// Whether all of a box of points is farther from the region than others are from all of it.
    fn is_beyond(&mut self, least: DVec3, greatest: DVec3) -> bool {
        let Aabb { min, max } = self.region;
        let farthest = (greatest - min).max(max - least).max(DVec3::ZERO).length_squared();
        self.within = self.within.min(farthest);
        let nearest = (least - max).max(min - greatest).max(DVec3::ZERO).length_squared();
        // A little more than the rounding of either.
        nearest > self.within * (1.0 + 1e-12)
    }
}

/// Which of some points, told by number, each position is nearest to: of equally near ones the first.
#[multiversion::multiversion(targets = "simd")]
fn nearest_among(positions: &[DVec3], points: &[DVec3], among: &[usize], found: &mut [usize]) {
    for (positions, found) in positions.chunks(LANES).zip(found.chunks_mut(LANES)) {
        let (mut x, mut y, mut z) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for (i, position) in positions.iter().enumerate() {
            (x[i], y[i], z[i]) = (position.x, position.y, position.z);
        }
        let (mut least, mut nearest) = ([f64::INFINITY; LANES], [among[0]; LANES]);
        for &number in among {
            let point = points[number];
            for i in 0..LANES {
                let (dx, dy, dz) = (point.x - x[i], point.y - y[i], point.z - z[i]);
                let distance = dx * dx + dy * dy + dz * dz;
                nearest[i] = select_unpredictable(distance < least[i], number, nearest[i]);
                least[i] = if distance < least[i] { distance } else { least[i] };
            }
        }
        found.copy_from_slice(&nearest[..found.len()]);
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

    /// The point of a number.
    pub fn point(&self, number: usize) -> DVec3 {
        self.points[number]
    }

    /// The nearest point and its number, which a later call for a position nearby may be given to start from.
    pub fn nearest(&self, position: DVec3, start: Option<usize>) -> Option<(usize, DVec3)> {
        let first = start.unwrap_or(0);
        let mut best = (self.points.get(first)?.distance_squared(position), first);
        self.search(position, 0, 0, self.points.len(), &mut best);
        Some((best.1, self.points[best.1]))
    }

    /// The number of the point nearest to each position, the same as by [`Self::nearest`]; none where there are no points.
    /// Faster where positions that follow one another lie together, by far where few points are near them all.
    pub fn nearest_each(&self, positions: &[DVec3], found: &mut Vec<usize>) {
        found.clear();
        if self.points.is_empty() {
            return;
        }
        let region = box_of(positions.iter().copied());
        let mut near = Near { region, within: f64::INFINITY, points: Vec::new() };
        if self.collect(0, 0, self.points.len(), &mut near) {
            // In the order of their numbers: of equally near points the first.
            near.points.sort_unstable();
            found.resize(positions.len(), 0);
            nearest_among(positions, &self.points, &near.points, found);
            return;
        }
        let mut last = None;
        for position in positions {
            last = self.nearest(*position, last).map(|(number, _)| number);
            found.extend(last);
        }
    }

    /// Collects those of the points `from..to` of a node that may be the nearest to a position of a region; `false` where
    /// they are too many.
    fn collect(&self, node: usize, from: usize, to: usize, near: &mut Near) -> bool {
        let Node { least, greatest, upper } = self.nodes[node];
        if near.is_beyond(least, greatest) {
            return true;
        }
        if to - from <= LEAF {
            for (number, point) in (from..to).zip(&self.points[from..to]) {
                if !near.is_beyond(*point, *point) {
                    near.points.push(number);
                }
            }
            return near.points.len() <= MOST_IN_TURN;
        }
        let middle = from + (to - from) / 2;
        let mut halves = [(node + 1, from, middle), (upper as usize, middle, to)];
        let distance = |half: &(usize, usize, usize)| self.nodes[half.0].distance_squared(near.region.centre());
        if distance(&halves[1]) < distance(&halves[0]) {
            halves.swap(0, 1);
        }
        halves.into_iter().all(|(node, from, to)| self.collect(node, from, to, near))
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

    /// Numbers from 0 to 1.
    fn random(mut state: u64) -> impl FnMut() -> f64 {
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    #[test]
    fn the_nearest_is_that_of_a_plain_search() {
        let mut unit = random(1);
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

    /// Near the points, among them and far away; where the positions' box holds few points, and where it holds many.
    #[test]
    fn positions_that_lie_together_find_the_same() {
        let mut unit = random(7);
        let points: Vec<DVec3> = (0..4000).map(|_| (DVec3::new(unit(), unit(), unit()) * 40.0).floor()).collect();
        let tree = PointTree::new(points);
        let mut found = Vec::new();
        for round in 0..60 {
            let middle = DVec3::new(unit(), unit(), unit()) * 90.0 - 25.0;
            let reach = [0.0, 0.5, 3.0, 30.0][round % 4];
            let position = |_| ((middle + DVec3::new(unit(), unit(), unit()) * reach) * 4.0).round() / 4.0;
            let positions: Vec<DVec3> = (0..1 + round * 7).map(position).collect();
            tree.nearest_each(&positions, &mut found);
            let alone = positions.iter().map(|position| tree.nearest(*position, None).expect("there are points").0);
            assert!(found.iter().copied().eq(alone));
        }
        PointTree::new(Vec::new()).nearest_each(&[DVec3::ZERO], &mut found);
        assert!(found.is_empty());
    }
}
