//! The values of all voxels, weighted by a power of the distance (STB, eq. 4): c = Σ cⱼ/dⱼᵖ / Σ 1/dⱼᵖ.
//!
//! Summed for a few points at a time over nodes of an octree. For a node of N voxels with the centroid m, each weight
//! w(x) = |x − a|⁻ᵖ at the point a is replaced by its first two terms around m,
//!
//! ŵⱼ = w(m) + ∇w(m)·hⱼ, hⱼ = xⱼ − m,
//!
//! so that Σ ŵⱼ = N w(m), as Σ hⱼ = 0, and Σ ŵⱼ cⱼ = w(m) Σ cⱼ + ∇w(m)·Σ hⱼ cⱼ. **The error.** The second derivatives of w
//! at the distance r are p(p + 1) r⁻⁽ᵖ⁺²⁾ along the line to a and −p r⁻⁽ᵖ⁺²⁾ across it, so by Taylor's theorem, with r the
//! distance from a to the node's box, which is convex and holds m and all xⱼ,
//!
//! Σ |ŵⱼ − wⱼ| ≤ E = ½ p(p + 1) r⁻⁽ᵖ⁺²⁾ Σ hⱼ².
//!
//! The value ĉ that the ŵ give differs from c by Σ (ŵⱼ − wⱼ)(cⱼ − c) / Σ ŵⱼ, as Σ wⱼ(cⱼ − c) = 0. No cⱼ is further from
//! their mean c than the greatest R of all differences between two values, and Σ ŵⱼ ≥ Σ wⱼ − ΣE. So where ΣE ≤ ε Σ wⱼ,
//!
//! |ĉ − c| ≤ R ε/(1 − ε), number by number.
//!
//! Nodes are opened until that holds with ε = [`RELATIVE_ERROR`] for all points of a group, by the least distances
//! between boxes for E and the greatest for wⱼ. A voxel by itself is exact. Sums are in 32 bits, whose
//! rounding comes on top.

use std::ops::RangeInclusive;

use glam::{DVec3, Vec3};

use super::Volume;
use super::tree::{Below, Node, Tree, cube};
use crate::field::BATCH;

/// The powers of the distance that there are.
pub const POWERS: RangeInclusive<u32> = 2..=8;

/// ε: the part of all weight that may be wrong. Values are off by no more than ε/(1 − ε) of their range. Greater: steps between groups of points
/// begin to show; less: more nodes are opened.
pub const RELATIVE_ERROR: f64 = 1.0 / 256.0;

/// Points that share a choice of nodes. More: nodes near them are opened for points that need not; fewer: the choice
/// takes longer than the sum.
const GROUP: usize = 32;

/// Sums for points outside of the volume, with its own scratch memory.
pub(super) struct Potential<'a, const N: usize> {
    volume: &'a Volume<N>,
    tree: &'a Tree<N>,
    power: u32,
    open: Vec<Open>,
    opened: Vec<Open>,
    voxels: Vec<Single<N>>,
    nodes: Vec<Cluster<N>>,
}

/// A node that may have to be opened.
struct Open {
    node: u32,
    /// E, the greatest for the group.
    error: f64,
    /// Σ wⱼ, the least for the group.
    weight: f64,
}

/// A voxel, relative to the group's middle, scaled.
struct Single<const N: usize> {
    at: Vec3,
    value: [f32; N],
}

/// A node, relative to the group's middle, scaled.
struct Cluster<const N: usize> {
    at: Vec3,
    count: f32,
    value: [f32; N],
    /// p Σ h c.
    dipole: [[f32; 3]; N],
}

impl<'a, const N: usize> Potential<'a, N> {
    pub fn new(volume: &'a Volume<N>, tree: &'a Tree<N>, power: u32) -> Self {
        Self { volume, tree, power, open: vec![], opened: vec![], voxels: vec![], nodes: vec![] }
    }

    /// The values at points, each with its place in `out`. The points are put in another order.
    pub fn sample(&mut self, points: &mut [(DVec3, usize)], out: &mut [[f32; N]; BATCH]) {
        if points.is_empty() {
            return;
        }
        let (low, high) = around(points);
        if points.len() > GROUP {
            let size = high - low;
            let axis = (0..3).max_by(|a, b| size[*a].total_cmp(&size[*b])).unwrap_or(0);
            let middle = points.len() / 2;
            points.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
            let (left, right) = points.split_at_mut(middle);
            self.sample(left, out);
            self.sample(right, out);
            return;
        }
        let centre = (low + high) / 2.0;
        let scale = self.choose(low, high, centre);
        let mut sums = Sums::new(points, centre, scale);
        add_all(self.power, &mut sums, &self.nodes, &self.voxels);
        for (i, (_, place)) in points.iter().enumerate() {
            out[*place] = sums.value.map(|sum| sum[i] / sums.weight[i]);
        }
    }

    /// Chooses nodes and voxels for the points of a box. Returns what lengths are multiplied by.
    fn choose(&mut self, low: DVec3, high: DVec3, centre: DVec3) -> f64 {
        let group = Group { low, high, power: self.power };
        self.voxels.clear();
        self.nodes.clear();
        self.open.clear();
        self.open.push(group.judge(0, &self.tree.nodes[0]));
        let mut exact = 0.0;
        loop {
            let error: f64 = self.open.iter().map(|open| open.error).sum();
            let weight: f64 = exact + self.open.iter().map(|open| open.weight).sum::<f64>();
            // Where the sum is too great, so is one that is above their mean.
            let share = RELATIVE_ERROR * weight / self.open.len() as f64;
            if error <= RELATIVE_ERROR * weight || self.open.iter().all(|open| open.error <= share) {
                break;
            }
            self.opened.clear();
            for open in self.open.drain(..) {
                if open.error <= share {
                    self.opened.push(open);
                    continue;
                }
                match self.tree.nodes[open.node as usize].below {
                    Below::Nodes(first, count) => {
                        let children = first..first + u32::from(count);
                        self.opened.extend(children.map(|child| group.judge(child, &self.tree.nodes[child as usize])));
                    }
                    Below::Voxels { block, place } => {
                        for (voxel, value) in cube(self.volume, block, place, 2) {
                            let voxel = voxel.as_dvec3();
                            exact += group.weight(voxel, voxel);
                            self.voxels.push(Single { at: (voxel - centre).as_vec3(), value });
                        }
                    }
                }
            }
            std::mem::swap(&mut self.open, &mut self.opened);
        }
        self.scale(centre, exact + self.open.iter().map(|open| open.weight).sum::<f64>())
    }

    /// Makes the chosen ones ready for the sums, in the unit of length in which all weight together is about 1: far
    /// away, powers of distances in voxels are beyond 32 bits. Returns one over that unit.
    fn scale(&mut self, centre: DVec3, weight: f64) -> f64 {
        let scale = libm::pow(weight, 1.0 / f64::from(self.power));
        self.voxels.iter_mut().for_each(|voxel| voxel.at *= scale as f32);
        let moment = (f64::from(self.power) * scale) as f32;
        self.nodes.extend(self.open.iter().map(|open| {
            let Node { centroid, count, value, dipole, .. } = self.tree.nodes[open.node as usize];
            let dipole = dipole.map(|number| number.map(|part| moment * part));
            Cluster { at: ((centroid - centre) * scale).as_vec3(), count, value, dipole }
        }));
        scale
    }
}

/// The box around points.
fn around(points: &[(DVec3, usize)]) -> (DVec3, DVec3) {
    let start = (points[0].0, points[0].0);
    points.iter().fold(start, |(low, high), (at, _)| (low.min(*at), high.max(*at)))
}

/// The box of the points that nodes are chosen for.
struct Group {
    low: DVec3,
    high: DVec3,
    power: u32,
}

impl Group {
    /// What a node costs in error and is worth in weight.
    fn judge<const N: usize>(&self, index: u32, node: &Node<N>) -> Open {
        let (low, high) = (node.low.as_dvec3(), node.high.as_dvec3());
        let gap = (low - self.high).max(self.low - high).max(DVec3::ZERO).length_squared();
        let power = f64::from(self.power);
        let spread = f64::from(node.spread);
        let error = match spread > 0.0 {
            true => 0.5 * power * (power + 1.0) * inverse_power(gap, self.power + 2) * spread,
            false => 0.0,
        };
        Open { node: index, error, weight: f64::from(node.count) * self.weight(low, high) }
    }

    /// The least weight that a voxel of a box can have.
    fn weight(&self, low: DVec3, high: DVec3) -> f64 {
        inverse_power((high - self.low).max(self.high - low).length_squared(), self.power)
    }
}

/// r⁻ᵖ of r².
fn inverse_power(squared: f64, power: u32) -> f64 {
    let even = (0..power / 2).fold(1.0, |product, _| product / squared);
    if power % 2 == 1 { even / squared.sqrt() } else { even }
}

/// The points of a group, relative to its middle, scaled, and what is summed there.
struct Sums<const N: usize> {
    at: [[f32; GROUP]; 3],
    weight: [f32; GROUP],
    value: [[f32; GROUP]; N],
}

impl<const N: usize> Sums<N> {
    fn new(points: &[(DVec3, usize)], centre: DVec3, scale: f64) -> Self {
        // Places without a point repeat the first: nothing is divided by 0 there.
        let at = |axis: usize| {
            std::array::from_fn(|i| {
                let (at, _) = points[if i < points.len() { i } else { 0 }];
                ((at[axis] - centre[axis]) * scale) as f32
            })
        };
        Self { at: std::array::from_fn(at), weight: [0.0; GROUP], value: [[0.0; GROUP]; N] }
    }
}

#[multiversion::multiversion(targets = "simd")]
fn add_all<const N: usize>(power: u32, sums: &mut Sums<N>, nodes: &[Cluster<N>], voxels: &[Single<N>]) {
    match power {
        2 => add::<N, 1, false>(sums, nodes, voxels),
        3 => add::<N, 1, true>(sums, nodes, voxels),
        4 => add::<N, 2, false>(sums, nodes, voxels),
        5 => add::<N, 2, true>(sums, nodes, voxels),
        6 => add::<N, 3, false>(sums, nodes, voxels),
        7 => add::<N, 3, true>(sums, nodes, voxels),
        8 => add::<N, 4, false>(sums, nodes, voxels),
        _ => unreachable!("one of POWERS"),
    }
}

/// r⁻ᵖ of r⁻²; p is twice `HALF`, and one more where `ODD`.
#[inline(always)]
fn weight<const HALF: usize, const ODD: bool>(inverse: f32) -> f32 {
    let mut weight = if ODD { inverse.sqrt() } else { 1.0 };
    for _ in 0..HALF {
        weight *= inverse;
    }
    weight
}

/// Adds nodes, then voxels. Inlined, so that it is compiled for its caller's vector width; each point's sum has the
/// same order for any.
#[inline(always)]
fn add<const N: usize, const HALF: usize, const ODD: bool>(
    sums: &mut Sums<N>,
    nodes: &[Cluster<N>],
    voxels: &[Single<N>],
) {
    let Sums { at: [x, y, z], weight: total, value: sums } = sums;
    for node in nodes {
        for i in 0..GROUP {
            let (dx, dy, dz) = (x[i] - node.at.x, y[i] - node.at.y, z[i] - node.at.z);
            let inverse = 1.0 / (dx * dx + dy * dy + dz * dz);
            let weight = weight::<HALF, ODD>(inverse);
            // The gradient of w by a voxel's place is p r⁻⁽ᵖ⁺²⁾ times the way from there to the point.
            let slope = weight * inverse;
            total[i] += node.count * weight;
            for number in 0..N {
                let [a, b, c] = node.dipole[number];
                sums[number][i] += node.value[number] * weight + slope * (a * dx + b * dy + c * dz);
            }
        }
    }
    for voxel in voxels {
        for i in 0..GROUP {
            let (dx, dy, dz) = (x[i] - voxel.at.x, y[i] - voxel.at.y, z[i] - voxel.at.z);
            let weight = weight::<HALF, ODD>(1.0 / (dx * dx + dy * dy + dz * dz));
            total[i] += weight;
            for number in 0..N {
                sums[number][i] += voxel.value[number] * weight;
            }
        }
    }
}
