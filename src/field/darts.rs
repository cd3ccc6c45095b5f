//! Points at random as far apart as a size that varies over space says: Poisson-disc darts, each with a radius of its own.
//!
//! An octree on a lattice that stands still is split until no cube is longer than the size in it (White, Cline and Egbert,
//! Poisson Disk Point Sets by Hierarchical Dart Throwing, 2007). Every leaf throws darts at places that are hashes of the
//! seed, its cube and the throw, as many for each size³; all are tried in the order of other hashes, and one stays that is
//! no nearer to any before it than the mean of both radii. Nothing depends on threads or on the order that space is asked in,
//! and a dart's fate on the few sizes around it.
//!
//! Guaranteed: the distances, and a dart's place to the bit. Not guaranteed: that no gap has room for another dart. There is one
//! dart in size³ within a few percent, wherever the size changes by less than itself over its own length.

use glam::{DVec3, I64Vec3};
use rayon::prelude::*;

use super::noise::hash::{Cubes, mixed, of_cell, shares};
use super::{Aabb, BATCH, Field, Points};

/// Throws for each size³. Fewer: larger gaps; more: the same points later, for the gaps close ever more slowly.
const THROWS: f64 = 40.0;

/// A dart's radius, of its size: with so many throws there is one dart in size³.
const RADIUS: f64 = 0.8346;

/// The throws of all leaves are made in so many rounds, the memory of one at a time. Fewer: more memory; more: longer.
const ROUNDS: u64 = 32;

/// The most cubes of the octree: half a gigabyte, and about a minute.
const MOST_NODES: usize = 1 << 22;

/// The largest size over the smallest: an octree of a few levels.
pub const WIDEST: f64 = 64.0;

/// Edges of a cube that it may be away from the solid: two to four cells. Fewer: what is thrown on one side of a surface hangs on
/// what the other side lacks.
const AROUND: f64 = 4.0;

/// Nodes whose sizes are looked up at once.
const CHUNK: usize = 4096;

/// Throws darts.
pub struct Darts<'a> {
    /// Where to.
    pub around: Aabb,
    /// The solid in which they count: what is some cells away from it gets none.
    pub solid: &'a dyn Field,
    /// The sizes where the share is 0 and where it is 1.
    pub sizes: [f64; 2],
    /// The share, which is held to 0 … 1.
    pub by: &'a dyn Field,
    /// What they start from.
    pub seed: u64,
}

/// A point that a dart hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dart {
    /// The point.
    pub at: DVec3,
    /// The share there, 0 to 1.
    pub share: f64,
}

/// Why there are no darts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DartError {
    /// There would be more than can be kept.
    TooMany,
    /// The share is no number there.
    NoNumber(DVec3),
}

/// The shares at some points, held to 0 … 1.
pub fn shares_at(by: &dyn Field, positions: &[DVec3]) -> Result<Vec<f64>, DartError> {
    let mut all = vec![0.0; positions.len()];
    all.par_chunks_mut(16 * BATCH).zip(positions.par_chunks(16 * BATCH)).try_for_each(|(all, positions)| {
        let (mut evaluator, mut values) = (by.evaluator(), [0.0; BATCH]);
        for (all, positions) in all.chunks_mut(BATCH).zip(positions.chunks(BATCH)) {
            // From one origin, so that a value does not hang on the points that it is asked with.
            let mut points = Points::new(DVec3::ZERO);
            positions.iter().for_each(|position| points.push(position.as_vec3()));
            evaluator.values(&points, &mut values);
            for ((share, value), position) in all.iter_mut().zip(values).zip(positions) {
                if value.is_nan() {
                    return Err(DartError::NoNumber(*position));
                }
                *share = f64::from(value.clamp(0.0, 1.0));
            }
        }
        Ok(())
    })?;
    Ok(all)
}

impl Darts<'_> {
    /// All that stay.
    pub fn thrown(&self) -> Result<Vec<Dart>, DartError> {
        let board = Board::new(self)?.hit(self.seed);
        let shares = shares_at(self.by, &board.darts)?;
        Ok(board.darts.into_iter().zip(shares).map(|(at, share)| Dart { at, share }).collect())
    }

    fn size(&self, share: f64) -> f64 {
        self.sizes[0] + (self.sizes[1] - self.sizes[0]) * share
    }
}

/// No node, no dart.
const NONE: u32 = u32::MAX;

#[derive(Clone, Copy)]
struct Node {
    /// The first of eight children, or none.
    children: u32,
    /// The last dart in a leaf, or none.
    dart: u32,
    /// The greatest radius of the darts in it; 0 where there is none.
    reach: f64,
}

struct Leaf {
    node: u32,
    level: u32,
    cube: I64Vec3,
    /// At its corners, z the fastest.
    sizes: [f32; 8],
    throws: f64,
    /// Of one throw, at which its first comes: leaves of few throws are spread over all rounds.
    phase: f64,
}

/// The octree with the darts so far.
struct Board {
    /// The edge of the roots.
    edge: f64,
    low: I64Vec3,
    count: I64Vec3,
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    darts: Vec<DVec3>,
    radii: Vec<f64>,
    /// The dart before in the same leaf.
    before: Vec<u32>,
}

/// A node that is to be split or to become a leaf.
type Open = (u32, I64Vec3);

impl Board {
    fn new(darts: &Darts<'_>) -> Result<Self, DartError> {
        let [edge, smallest] = [darts.sizes[0].max(darts.sizes[1]), darts.sizes[0].min(darts.sizes[1])];
        /// Edges from the origin: cubes of all levels are whole numbers far below where those end.
        const FARTHEST: f64 = 1e12;
        let cubes = Cubes::over(&darts.around, edge, MOST_NODES, FARTHEST);
        // Not a number is too wide, too.
        let cubes = cubes.filter(|_| edge <= WIDEST * smallest).ok_or(DartError::TooMany)?;
        let Cubes { low, count } = cubes;
        let (nodes, leaves) = (Vec::new(), Vec::new());
        let mut board =
            Self { edge, low, count, nodes, leaves, darts: Vec::new(), radii: Vec::new(), before: Vec::new() };
        let mut open: Vec<Open> = (0..).zip(cubes.iter()).collect();
        board.nodes.resize(open.len(), EMPTY);
        let mut level = 0;
        while !open.is_empty() {
            board.keep_near(darts, level, &mut open);
            let mut next = Vec::new();
            for some in open.chunks(CHUNK) {
                board.split(darts, level, some, &mut next)?;
            }
            (open, level) = (next, level + 1);
        }
        Ok(board)
    }

    /// Leaves out the nodes of a level that are far from the box or from the solid.
    fn keep_near(&self, darts: &Darts<'_>, level: u32, open: &mut Vec<Open>) {
        let (mut solid, edge) = (darts.solid.evaluator(), self.edge_at(level));
        open.retain(|(_, cube)| {
            let corner = cube.as_dvec3() * edge;
            let bounds = Aabb::new(corner, corner + edge);
            if bounds.intersection(darts.around).is_none() {
                return false;
            }
            solid.enter(&bounds.grown(AROUND * edge));
            let found = solid.bounds();
            solid.leave();
            found.hi >= 0.0 || found.hi.is_nan()
        });
    }

    /// Splits the nodes of a level whose cubes are longer than the size anywhere in them; the others become leaves.
    fn split(&mut self, darts: &Darts<'_>, level: u32, some: &[Open], next: &mut Vec<Open>) -> Result<(), DartError> {
        /// Points along an edge where the size is looked up: a place of small cells narrower than half of it may be missed.
        const SIDE: i64 = 3;
        let edge = self.edge_at(level);
        let step = edge / (SIDE - 1) as f64;
        let points: Vec<DVec3> = some
            .iter()
            .flat_map(|(_, cube)| {
                let corner = cube.as_dvec3() * edge;
                (0..SIDE * SIDE * SIDE)
                    .map(move |i| corner + I64Vec3::new(i / (SIDE * SIDE), i / SIDE % SIDE, i % SIDE).as_dvec3() * step)
            })
            .collect();
        let shares = shares_at(darts.by, &points)?;
        for ((node, cube), shares) in some.iter().zip(shares.chunks_exact((SIDE * SIDE * SIDE) as usize)) {
            let least = shares.iter().fold(f64::INFINITY, |least, share| least.min(darts.size(*share)));
            // Rounding of shares must not split what is as long as the smallest size.
            if edge > least * (1.0 + 1e-6) {
                if self.nodes.len() + 8 > MOST_NODES {
                    return Err(DartError::TooMany);
                }
                let first = self.nodes.len() as u32;
                self.nodes[*node as usize].children = first;
                self.nodes.extend([EMPTY; 8]);
                next.extend((0..8).map(|i| (first + i, *cube * 2 + octant(i))));
                continue;
            }
            let at = |i: usize| darts.size(shares[18 * (i / 4) + 6 * (i / 2 % 2) + 2 * (i % 2)]);
            let sizes = std::array::from_fn(|i| at(i) as f32);
            let volume = |i: usize| edge / at(i) * (edge / at(i)) * (edge / at(i));
            let mean = (0..8).map(volume).sum::<f64>() / 8.0;
            let phase = shares_of(*cube, darts.seed, level, u64::MAX).0.x;
            self.leaves.push(Leaf { node: *node, level, cube: *cube, sizes, throws: THROWS * mean, phase });
        }
        Ok(())
    }

    fn edge_at(&self, level: u32) -> f64 {
        self.edge / f64::from(1 << level)
    }

    /// With all darts thrown.
    fn hit(mut self, seed: u64) -> Self {
        let mut throws: Vec<(u64, u32, DVec3)> = Vec::new();
        for round in 0..ROUNDS {
            throws.clear();
            for (index, leaf) in self.leaves.iter().enumerate() {
                let until = |round: u64| (leaf.throws * round as f64 / ROUNDS as f64 + leaf.phase) as u64;
                for throw in until(round)..until(round + 1) {
                    let (within, order) = shares_of(leaf.cube, seed, leaf.level, throw);
                    throws.push((order, index as u32, within));
                }
            }
            throws.sort_unstable_by_key(|(order, leaf, _)| (*order, *leaf));
            for (_, leaf, within) in &throws {
                let Leaf { level, cube, sizes, .. } = &self.leaves[*leaf as usize];
                let at = (cube.as_dvec3() + *within) * self.edge_at(*level);
                let radius = RADIUS * between(sizes, *within);
                if self.is_free(at, radius) {
                    self.stick(*leaf as usize, at, radius);
                }
            }
        }
        self
    }

    /// Whether a dart may stay there.
    fn is_free(&self, at: DVec3, radius: f64) -> bool {
        let reach = (radius + RADIUS * self.edge) / 2.0;
        let last = self.low + self.count - 1;
        let low = ((at - reach) / self.edge).floor().as_i64vec3().clamp(self.low, last);
        let high = ((at + reach) / self.edge).floor().as_i64vec3().clamp(self.low, last);
        let own = (at / self.edge).floor().as_i64vec3().clamp(self.low, last);
        let is_free =
            |cube: I64Vec3| self.is_free_of(self.root(cube), cube.as_dvec3() * self.edge, self.edge, (at, radius));
        // Most are too near to one beside them, which is found first.
        if !is_free(own) {
            return false;
        }
        for x in low.x..=high.x {
            for y in low.y..=high.y {
                for z in low.z..=high.z {
                    let cube = I64Vec3::new(x, y, z);
                    if cube != own && !is_free(cube) {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// Whether a dart may stay there for all that the node of a cube holds.
    fn is_free_of(&self, node: usize, corner: DVec3, edge: f64, dart: (DVec3, f64)) -> bool {
        let (at, radius) = dart;
        let Node { children, dart: mut other, reach } = self.nodes[node];
        let away = (corner - at).max(at - (corner + edge)).max(DVec3::ZERO);
        let apart = (radius + reach) / 2.0;
        if reach == 0.0 || away.length_squared() >= apart * apart {
            return true;
        }
        if children != NONE {
            let half = edge / 2.0;
            let [x, y, z] = (at - corner).to_array().map(|along| u32::from(along >= half));
            let nearest = 4 * x + 2 * y + z;
            return (0..8)
                .map(|i| i ^ nearest)
                .all(|i| self.is_free_of((children + i) as usize, corner + octant(i).as_dvec3() * half, half, dart));
        }
        while other != NONE {
            let apart = (radius + self.radii[other as usize]) / 2.0;
            if self.darts[other as usize].distance_squared(at) < apart * apart {
                return false;
            }
            other = self.before[other as usize];
        }
        true
    }

    /// Keeps a dart in a leaf.
    fn stick(&mut self, leaf: usize, at: DVec3, radius: f64) {
        let Leaf { node: last, level, cube, .. } = self.leaves[leaf];
        let above = |by: u32| I64Vec3::new(cube.x >> by, cube.y >> by, cube.z >> by);
        let mut node = self.root(above(level));
        for by in (0..level).rev() {
            self.nodes[node].reach = self.nodes[node].reach.max(radius);
            let way = above(by) & I64Vec3::ONE;
            node = self.nodes[node].children as usize + (way.x * 4 + way.y * 2 + way.z) as usize;
        }
        debug_assert_eq!(node, last as usize);
        let leaf = &mut self.nodes[node];
        leaf.reach = leaf.reach.max(radius);
        self.before.push(leaf.dart);
        leaf.dart = self.darts.len() as u32;
        self.darts.push(at);
        self.radii.push(radius);
    }

    fn root(&self, cube: I64Vec3) -> usize {
        let I64Vec3 { x, y, z } = cube - self.low;
        ((x * self.count.y + y) * self.count.z + z) as usize
    }
}

const EMPTY: Node = Node { children: NONE, dart: NONE, reach: 0.0 };

/// The way to a child, in cubes of its size.
fn octant(i: u32) -> I64Vec3 {
    I64Vec3::new(i64::from(i >> 2), i64::from(i >> 1 & 1), i64::from(i & 1))
}

/// Where in its cube a throw goes, as shares of its edge, and its place in the order.
fn shares_of(cube: I64Vec3, seed: u64, level: u32, throw: u64) -> (DVec3, u64) {
    let bits = of_cell(cube, mixed(mixed(seed) ^ u64::from(level)) ^ throw);
    (shares(bits), mixed(bits))
}

/// Of eight corners' values.
fn between(values: &[f32; 8], at: DVec3) -> f64 {
    let mut sum = 0.0;
    for (i, value) in (0..8).zip(values) {
        let near = octant(i).as_dvec3();
        let weight = DVec3::ONE - (near - at).abs();
        sum += f64::from(*value) * weight.element_product();
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Expression, Formula, Graph, Names};

    fn by_formula(text: &str) -> Expression {
        let mut graph = Graph::new();
        let names = Names::space(&mut graph);
        let node = Formula::parse(text).compile(&mut graph, &names).expect("a formula");
        Expression::new(&graph, node).keeping_values()
    }

    fn everywhere() -> Expression {
        by_formula("1 + 0*x")
    }

    fn cube(half: f64) -> Aabb {
        Aabb::new(DVec3::splat(-half), DVec3::splat(half))
    }

    fn within(darts: &[Dart], half: f64) -> Vec<Dart> {
        darts.iter().filter(|dart| dart.at.abs().max_element() < half).copied().collect()
    }

    /// There is one dart in size³ for sizes that are the same all over, whatever part of the octree's edge they are.
    #[test]
    fn the_mean_cell_has_the_wanted_size() {
        for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let by = by_formula(&format!("{share} + 0*x"));
            let darts = Darts { around: cube(1.6), solid: &everywhere(), sizes: [0.08, 0.16], by: &by, seed: 1 };
            let found = within(&darts.thrown().expect("few"), 1.3);
            let mean = (2.6_f64.powi(3) / found.len() as f64).cbrt();
            assert!((mean / darts.size(share) - 1.0).abs() < 0.02, "{share}: {mean}");
        }
    }

    const GROWING: &str = "0.5 + 0.5*x/1.3";

    /// The mean size of cells in each slab across x is that of the sizes wanted there: of 1/size³ darts.
    #[test]
    fn cells_grow_as_the_size_does() {
        let by = by_formula(GROWING);
        let darts = Darts { around: cube(1.6), solid: &everywhere(), sizes: [0.06, 0.24], by: &by, seed: 3 };
        let found = within(&darts.thrown().expect("few"), 1.3);
        let size = |x: f64| darts.size(0.5 + 0.5 * x / 1.3);
        for slab in 0..10 {
            let (from, to) = (-1.3 + 0.26 * f64::from(slab), -1.04 + 0.26 * f64::from(slab));
            let count = found.iter().filter(|dart| (from..to).contains(&dart.at.x)).count();
            let wanted =
                (0..100).map(|i| size(from + (to - from) * (f64::from(i) + 0.5) / 100.0).powi(-3)).sum::<f64>() / 100.0
                    * 2.6
                    * 2.6
                    * (to - from);
            let ratio = (wanted / count as f64).cbrt();
            assert!((ratio - 1.0).abs() < 0.03, "{from}: {count} for {wanted}");
        }
    }

    /// Of all pairs, one by one.
    #[test]
    fn no_two_are_nearer_than_the_mean_of_their_radii() {
        let by = by_formula(GROWING);
        let darts = Darts { around: cube(0.6), solid: &everywhere(), sizes: [0.05, 0.3], by: &by, seed: 4 };
        let found = darts.thrown().expect("few");
        assert!(found.len() > 500, "{}", found.len());
        for (i, a) in found.iter().enumerate() {
            assert!((a.share - (0.5 + 0.5 * a.at.x / 1.3)).abs() < 1e-6);
            for b in &found[i + 1..] {
                let apart = RADIUS * (darts.size(a.share) + darts.size(b.share)) / 2.0;
                assert!(a.at.distance(b.at) > apart * (1.0 - 1e-5), "{a:?} {b:?}");
            }
        }
    }

    /// Where a part of space is asked for, and on how many threads, makes no difference a few cells from its border.
    #[test]
    fn a_larger_box_has_the_same_darts() {
        let by = by_formula(GROWING);
        let of = |around: Aabb, threads: usize| {
            let darts = Darts { around, solid: &everywhere(), sizes: [0.06, 0.12], by: &by, seed: 5 };
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let mut found = within(&pool.install(|| darts.thrown()).expect("few"), 0.4);
            found.sort_by(|a, b| a.at.x.total_cmp(&b.at.x));
            found
        };
        let found = of(cube(1.0), 1);
        assert!(found.len() > 300, "{}", found.len());
        assert_eq!(found, of(cube(1.0), 2));
        assert_eq!(found, of(Aabb::new(DVec3::new(-1.13, -0.97, -1.31), DVec3::new(1.07, 1.4, 1.21)), 2));
    }

    /// A size that jumps is followed on both sides.
    #[test]
    fn sizes_may_jump() {
        let by = by_formula("1000*x");
        let darts = Darts { around: cube(1.5), solid: &everywhere(), sizes: [0.06, 0.24], by: &by, seed: 6 };
        let found = within(&darts.thrown().expect("few"), 1.0);
        for (size, side) in [(0.06, -1.0), (0.24, 1.0)] {
            let count = found.iter().filter(|dart| dart.at.x * side > 0.25).count();
            let ratio = (0.75 * 4.0 / size / size / size / count as f64).cbrt();
            assert!((ratio - 1.0).abs() < 0.04, "{size}: {ratio}");
        }
    }

    /// What is far from the solid gets none, and what is in it the same.
    #[test]
    fn a_solid_has_the_darts_of_all_space() {
        let (by, solid) = (by_formula(GROWING), by_formula("0.3 - sqrt(x^2 + y^2 + z^2)"));
        let of = |solid: &dyn Field| {
            Darts { around: cube(1.5), solid, sizes: [0.06, 0.12], by: &by, seed: 7 }.thrown().expect("few")
        };
        let (some, all) = (of(&solid), of(&everywhere()));
        assert!(8 * some.len() < all.len(), "{} of {}", some.len(), all.len());
        let inside = |darts: &[Dart]| {
            let mut found: Vec<Dart> = darts.iter().filter(|dart| dart.at.length() < 0.3).copied().collect();
            found.sort_by(|a, b| a.at.x.total_cmp(&b.at.x));
            found
        };
        assert_eq!(inside(&some), inside(&all));
        assert!(inside(&some).len() > 80, "{}", inside(&some).len());
    }

    #[test]
    fn what_cannot_be_thrown_is_told() {
        let thrown = |text: &str, half: f64| {
            Darts { around: cube(half), solid: &everywhere(), sizes: [0.01, 0.1], by: &by_formula(text), seed: 0 }
                .thrown()
        };
        assert_eq!(thrown("0*x", 3.0), Err(DartError::TooMany));
        assert_eq!(thrown("1 + 0*x", f64::INFINITY), Err(DartError::TooMany));
        assert_eq!(thrown("1 + 0*x", f64::NAN), Err(DartError::TooMany));
        assert!(matches!(thrown("sqrt(x)", 0.2), Err(DartError::NoNumber(at)) if at.x < 0.0));
    }
}
