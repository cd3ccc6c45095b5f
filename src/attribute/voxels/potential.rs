//! The values of all voxels, weighted by a power of the distance (STB, eq. 4): c = Σ cⱼ/dⱼᵖ / Σ 1/dⱼᵖ.
//!
//! Summed over nodes of an octree, by series for all points of a group at once. Let A be a group's middle, u = a − A, m
//! a node's centroid and hⱼ = m − xⱼ. Each weight wⱼ = |a − xⱼ|⁻ᵖ = φ(A − m + u + hⱼ), φ(y) = |y|⁻ᵖ, is replaced by the
//! terms of its Taylor series around y = A − m of less than the n-th degree, n = 6,
//!
//! ŵⱼ = Σ ∂ᵅφ(A − m) (u + hⱼ)ᵅ/α!, |α| < n.
//!
//! As (u + h)ᵅ/α! = Σ u^β/β! hᵞ/γ!, β + γ = α, their sum Σ ŵⱼ (1, cⱼ) over all voxels of all nodes is one polynomial of u,
//! from the nodes' moments Σ hᵞ/γ! (1, c).
//!
//! **The error.** Where |z| < d = |y|, the terms of φ(y + z) of the degree k together are no more than
//! B(k) |z|ᵏ d⁻⁽ᵖ⁺ᵏ⁾, B(k) = C(p + k − 1, k), for φ generates the Gegenbauer polynomials of the order p/2, which are
//! greatest at 1. Let |u| ≤ ρ, |hⱼ| ≤ H, and η be no less than the n-th root of the mean of |hⱼ|ⁿ over the node's N voxels: that of
//! Σ |hⱼ|⁴ Hⁿ⁻⁴/N. Then
//! z = u + hⱼ is no longer than q d, q = (ρ + H)/d, and by Minkowski's inequality Σ |z|ⁿ ≤ N (ρ + η)ⁿ. So where q < 1
//!
//! Σ |ŵⱼ − wⱼ| ≤ Σ |zⱼ|ⁿ d⁻⁽ᵖ⁺ⁿ⁾ Σ B(n + i) qⁱ ≤ E = N B(n) (ρ + η)ⁿ d⁻⁽ᵖ⁺ⁿ⁾ ((1 − q)⁻ᵖ + n/(1 − q))/(n + 1),
//!
//! for Σ B(n + i) qⁱ = B(n) (1 − q)⁻ᵖ ∫ n tⁿ⁻¹ (1 − q t)ᵖ⁻¹ dt over 0 … 1 (Euler's), where the last power, convex in t, is
//! below its chord.
//!
//! **The weight** is never less than W = N (|a − m|² + Σ hⱼ²/N)^(−p/2), since r⁻ᵖ is convex in r², whose mean over the node
//! is |a − m|² + Σ hⱼ²/N. It is taken of each point.
//!
//! **The value** ĉ that the ŵ give differs from c by Σ (ŵⱼ − wⱼ)(cⱼ − c) / Σ ŵⱼ, as Σ wⱼ(cⱼ − c) = 0. No cⱼ is further from
//! their mean c than the greatest R of all differences between two values, and Σ ŵⱼ ≥ Σ wⱼ − ΣE. So where ΣE ≤ ε Σ wⱼ,
//!
//! |ĉ − c| ≤ R ε/(1 − ε), number by number.
//!
//! Nodes are chosen so that this holds with ε = [`RELATIVE_ERROR`] for all points of a block, then for parts of it of
//! half the radius, down to a few points. In each part the nodes of the greatest E are opened until ΣE is within the
//! part's share of ε, but where η is less than 2ρ they are put off to the parts of the part. The fewest points open all,
//! and sum cubes of 4³ voxels, as they come to them, voxel by voxel.
//! Sums are in 32 bits, whose rounding comes on top.

use std::ops::RangeInclusive;

use glam::{DVec3, Vec3};

use super::bound::{Ball, inverse_power};
use super::clusters::Clusters;
use super::group::{Group, ball, halves};
use super::series::{LANES, Series, evaluate};
use super::tree::{Below, Tree, cube};
use super::{Volume, three};
use crate::attribute::LinearRgb;
use crate::field::BATCH;

/// The powers of the distance that there are.
pub const POWERS: RangeInclusive<u32> = 2..=8;

/// ε: the part of all weight that may be wrong. Colours are off by no more than ε/(1 − ε) of the range of their
/// channel; what was measured is far less, for errors of nodes go either way (see the tests). Greater: steps between
/// groups of points may show; less: more nodes are opened.
pub const RELATIVE_ERROR: f64 = 1.0 / 128.0;

/// The part of the ε that is left which each part but the fewest points may take. Greater: less is left to them, and
/// more is summed voxel by voxel; less: more nodes are opened.
const SHARE: f64 = 0.8;

/// How many nodes of the greatest error that they may have are within a part's share. Greater: nodes are opened that
/// need not be; less: more rounds are needed.
const FEWEST: f64 = 128.0;

/// How many times the error of another node a cube of 4³ may have until it is put off, or summed voxel by voxel.
/// Greater: more other nodes are opened; less: more cubes are summed.
const CUBE_SHARE: f64 = 8.0;

/// Nodes are put off whose η is less than this times ρ. Greater: more nodes are put off, and summed for each part;
/// less: more nodes are opened, though the points' own spread makes the error.
const FINE: f64 = 2.0;

/// Nodes with a radius of more than this part of their distance are opened for the least weight. Greater: it is less
/// than it could be, and nodes are opened for it; less: finding it takes longer.
const WEIGHED: f64 = 0.5;

/// The greatest radius of points that share a choice of nodes, in voxels, unless the volume is as far away. Greater: more
/// nodes are put off; less: nodes are chosen more often.
const RADIUS: f64 = 8.0;

/// Sums for points outside of the volume, with its own scratch memory.
pub(super) struct Potential<'a, const N: usize> {
    volume: &'a Volume<N>,
    tree: &'a Tree,
    clusters: &'a Clusters,
    power: u32,
    /// The least weight at each place of a batch.
    least: Vec<f64>,
    /// Nodes that are put off, of the parts that are open.
    waiting: Vec<u32>,
    /// Nodes of a part.
    chosen: Vec<Chosen>,
    /// The series of the parts that are open.
    series: Vec<Series>,
    voxels: Vec<Voxel>,
}

/// A node with its E.
struct Chosen {
    node: u32,
    error: f64,
}

/// A voxel, relative to the middle of a group.
struct Voxel {
    at: Vec3,
    colour: LinearRgb,
}

/// Sums at points side by side: weights, red, green, blue.
type Sums = [[f32; LANES]; 4];

/// What the parts of a block share. Weights are multiplied by r⁻ᵖ → (s r²)^(−p/2), so that all together are about 1: far
/// away, powers of distances in voxels are beyond 32 bits.
#[derive(Clone, Copy)]
struct Unit {
    scale: f32,
    weight: f64,
}

impl<'a, const N: usize> Potential<'a, N> {
    pub fn new(volume: &'a Volume<N>, tree: &'a Tree, clusters: &'a Clusters, power: u32) -> Self {
        Self {
            volume,
            tree,
            clusters,
            power,
            least: vec![0.0; BATCH],
            waiting: vec![],
            chosen: vec![],
            series: vec![],
            voxels: vec![],
        }
    }

    /// The colours at points, each with its place in `out`. The points are put in another order.
    pub fn sample(&mut self, points: &mut Group, out: &mut [[f32; N]; BATCH]) {
        if points.is_empty() {
            return;
        }
        let (middle, radius) = ball(points);
        let root = &self.clusters.nodes[0];
        let away = middle.distance(root.centroid) - f64::from(root.radius);
        if points.len() > LANES && radius > RADIUS.max(away / 4.0) {
            let (left, right) = halves(points);
            self.sample(left, out);
            self.sample(right, out);
        } else {
            let unit = self.weigh(points, middle, radius);
            self.waiting.clear();
            self.waiting.push(0);
            self.part(unit, points, 0, 0.0, f64::INFINITY, out);
        }
    }

    /// Finds the least weights at points.
    fn weigh(&mut self, points: &Group, middle: DVec3, radius: f64) -> Unit {
        self.waiting.clear();
        self.waiting.push(0);
        self.voxels.clear();
        let mut all = 0.0;
        self.chosen.clear();
        while let Some(index) = self.waiting.pop() {
            let cluster = &self.clusters.nodes[index as usize];
            let squared = cluster.centroid.distance_squared(middle);
            let reach = (f64::from(cluster.radius) + radius) / WEIGHED;
            match self.tree.nodes[index as usize].below {
                Below::Nodes(first, count) if squared < reach * reach => {
                    self.waiting.extend(first..first + u32::from(count));
                }
                _ => {
                    let mean = squared + f64::from(cluster.spread);
                    all += f64::from(cluster.count) * inverse_power(mean, self.power);
                    self.chosen.push(Chosen { node: index, error: 0.0 });
                }
            }
        }
        let scale = libm::pow(all, -2.0 / f64::from(self.power)) as f32;
        let nodes: Vec<(Vec3, f32, f32)> = self
            .chosen
            .iter()
            .map(|chosen| {
                let cluster = &self.clusters.nodes[chosen.node as usize];
                ((cluster.centroid - middle).as_vec3(), cluster.spread, cluster.count)
            })
            .collect();
        for points in points.chunks(LANES) {
            let mut sums = [0.0; LANES];
            weigh_all(self.power, scale, &ways(points, middle), &nodes, &mut sums);
            points.iter().zip(sums).for_each(|((_, place), sum)| self.least[*place] = f64::from(sum) * all);
        }
        Unit { scale, weight: all }
    }

    /// Sums for a part of a block, of nodes waiting from a place on. `above` is the ΣE of the series that are open.
    fn part(
        &mut self,
        unit: Unit,
        points: &mut Group,
        first: usize,
        above: f64,
        radius_above: f64,
        out: &mut [[f32; N]; BATCH],
    ) {
        let (middle, radius) = ball(points);
        let is_last = points.len() <= LANES;
        if !is_last && radius > radius_above / 2.0 {
            let (left, right) = halves(points);
            self.part(unit, left, first, above, radius_above, out);
            self.part(unit, right, first, above, radius_above, out);
            return;
        }
        let ball = Ball { middle, radius, power: self.power };
        let mut least = points.iter().map(|(_, place)| self.least[*place]).fold(f64::INFINITY, f64::min);
        let at = ways(points, middle);
        let mut sums = [[0.0; LANES]; 4];
        let behind = self.waiting.len();
        let (nodes, clusters) = (&self.tree.nodes, &self.clusters.nodes);
        let judge = |node: u32| Chosen { node, error: ball.error(&clusters[node as usize]) };
        self.chosen.clear();
        self.chosen.extend(self.waiting[first..behind].iter().map(|node| judge(*node)));
        let mut error: f64;
        let mut most = f64::INFINITY;
        loop {
            error = self.chosen.iter().map(|chosen| chosen.error).sum::<f64>();
            let allowed = RELATIVE_ERROR * least - above;
            let allowed = if is_last { allowed } else { SHARE * allowed };
            if error <= allowed {
                break;
            }
            most = (most / 2.0).min(allowed / FEWEST);
            let mut i = 0;
            self.voxels.clear();
            while i < self.chosen.len() {
                let Chosen { node, error } = self.chosen[i];
                if error <= most {
                    i += 1;
                    continue;
                }
                let below = nodes[node as usize].below;
                match below {
                    Below::Voxels { .. } if error <= CUBE_SHARE * most => i += 1,
                    Below::Voxels { block, place } if is_last => {
                        self.chosen.swap_remove(i);
                        self.voxels.extend(cube(self.volume, block, place).map(|(voxel, value)| Voxel {
                            at: (voxel.as_dvec3() - middle).as_vec3(),
                            colour: three(value),
                        }));
                    }
                    Below::Nodes(first, count)
                        if is_last || f64::from(clusters[node as usize].size) > FINE * radius =>
                    {
                        // The first takes its parent's place and is looked at next, the others wait at the end.
                        self.chosen[i] = judge(first);
                        self.chosen.extend((first + 1..first + u32::from(count)).map(judge));
                    }
                    _ => {
                        self.chosen.swap_remove(i);
                        self.waiting.push(node);
                    }
                }
            }
            if !self.voxels.is_empty() {
                add_voxels(self.power, unit.scale, &at, &self.voxels, &mut sums);
                let exact = sums[0][..points.len()].iter().copied().fold(f32::INFINITY, f32::min);
                least = least.max(f64::from(exact) * unit.weight);
            }
        }
        let clusters = self.clusters;
        let nodes = self.chosen.iter().map(|chosen| {
            let node = chosen.node as usize;
            (clusters.nodes[node].centroid, &clusters.moments[node])
        });
        self.series.push(Series::new(middle, self.power, unit.scale, nodes));
        if is_last || self.waiting.len() == behind {
            for points in points.chunks(LANES) {
                for series in &self.series {
                    evaluate(series, &ways(points, series.around), &mut sums);
                }
                let [weight, red, green, blue] = sums;
                for (i, (_, place)) in points.iter().enumerate() {
                    let numbers = [red[i], green[i], blue[i]];
                    out[*place] = std::array::from_fn(|number| numbers[number] / weight[i]);
                }
                sums = [[0.0; LANES]; 4];
            }
        } else {
            let (left, right) = halves(points);
            self.part(unit, left, behind, above + error, radius, out);
            self.part(unit, right, behind, above + error, radius, out);
        }
        self.waiting.truncate(behind);
        self.series.pop();
    }
}

/// The ways from a middle to points side by side.
fn ways(points: &Group, middle: DVec3) -> [[f32; LANES]; 3] {
    // Lanes without a point repeat the first: nothing is divided by 0 there.
    let at = |axis: usize| {
        std::array::from_fn(|i| {
            let (at, _) = points[if i < points.len() { i } else { 0 }];
            (at[axis] - middle[axis]) as f32
        })
    };
    std::array::from_fn(at)
}

/// Adds the least weights of nodes at points.
#[multiversion::multiversion(targets = "simd")]
fn weigh_all(
    power: u32,
    scale: f32,
    [x, y, z]: &[[f32; LANES]; 3],
    nodes: &[(Vec3, f32, f32)],
    sums: &mut [f32; LANES],
) {
    let mut total = *sums;
    for (at, spread, count) in nodes {
        let mut inverse = [0.0; LANES];
        let mut weight = [*count; LANES];
        for i in 0..LANES {
            let (dx, dy, dz) = (x[i] - at.x, y[i] - at.y, z[i] - at.z);
            inverse[i] = scale / (dx * dx + dy * dy + dz * dz + spread);
        }
        if power % 2 == 1 {
            for i in 0..LANES {
                weight[i] *= inverse[i].sqrt();
            }
        }
        for _ in 0..power / 2 {
            for i in 0..LANES {
                weight[i] *= inverse[i];
            }
        }
        for i in 0..LANES {
            total[i] += weight[i];
        }
    }
    *sums = total;
}

#[multiversion::multiversion(targets = "simd")]
fn add_voxels(power: u32, scale: f32, at: &[[f32; LANES]; 3], voxels: &[Voxel], sums: &mut Sums) {
    match power {
        2 => add::<1, false>(scale, at, voxels, sums),
        3 => add::<1, true>(scale, at, voxels, sums),
        4 => add::<2, false>(scale, at, voxels, sums),
        5 => add::<2, true>(scale, at, voxels, sums),
        6 => add::<3, false>(scale, at, voxels, sums),
        7 => add::<3, true>(scale, at, voxels, sums),
        8 => add::<4, false>(scale, at, voxels, sums),
        _ => unreachable!("one of POWERS"),
    }
}

/// Adds voxels; p is twice `HALF`, and one more where `ODD`. Inlined, so that it is compiled for its caller's vector
/// width; each point's sum has the same order for any.
#[inline(always)]
fn add<const HALF: usize, const ODD: bool>(
    scale: f32,
    [x, y, z]: &[[f32; LANES]; 3],
    voxels: &[Voxel],
    sums: &mut Sums,
) {
    let [mut total, mut red, mut green, mut blue] = *sums;
    for voxel in voxels {
        for i in 0..LANES {
            let (dx, dy, dz) = (x[i] - voxel.at.x, y[i] - voxel.at.y, z[i] - voxel.at.z);
            let inverse = scale / (dx * dx + dy * dy + dz * dz);
            let mut weight = if ODD { inverse.sqrt() } else { 1.0 };
            for _ in 0..HALF {
                weight *= inverse;
            }
            total[i] += weight;
            red[i] += voxel.colour[0] * weight;
            green[i] += voxel.colour[1] * weight;
            blue[i] += voxel.colour[2] * weight;
        }
    }
    *sums = [total, red, green, blue];
}
