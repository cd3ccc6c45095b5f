//! What the sum over all voxels needs of a tree's nodes.

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use super::series::{Coefficients, DEGREE, ZERO, monomials, shift, shifted_fourth, square_sum};
use super::tree::{Below, Node, Tree, cube};
use super::{Volume, three};

/// A node's voxels. h is the way from a voxel's centre to their centroid.
#[derive(Clone)]
pub(super) struct Cluster {
    /// The mean of their centres.
    pub centroid: DVec3,
    /// How many there are.
    pub count: f32,
    /// The mean of h².
    pub spread: f32,
    /// η: no less than the n-th root of the mean of |h|ⁿ, n one more than the series' degree.
    pub size: f32,
    /// The mean of |h|⁴.
    fourth: f64,
    /// No less than the greatest |h|.
    pub radius: f32,
}

/// The nodes of a tree, in its order.
pub(super) struct Clusters {
    pub nodes: Vec<Cluster>,
    /// Σ hᵅ/α! (1, c).
    pub moments: Vec<Coefficients>,
}

/// Memory of a node.
pub(super) const BYTES_A_NODE: u64 = (size_of::<Cluster>() + size_of::<Coefficients>()) as u64;

impl Clusters {
    pub fn new<const N: usize>(volume: &Volume<N>, tree: &Tree) -> Self {
        let leaf = |node: &Node| match node.below {
            Below::Voxels { block, place } => of_cube(volume, block, place),
            Below::Nodes(..) => (Cluster::around(DVec3::ZERO, 0.0), ZERO),
        };
        let (mut nodes, mut moments): (Vec<_>, Vec<_>) = tree.nodes.par_iter().map(leaf).unzip();
        for (i, node) in tree.nodes.iter().enumerate().rev() {
            if let Below::Nodes(first, count) = node.below {
                let children = first as usize..first as usize + usize::from(count);
                let (mut whole, sums) = of_parts(&nodes[children.clone()], &moments[children]);
                whole.radius = whole.radius.min(farthest(whole.centroid, node.low, node.high) as f32);
                (nodes[i], moments[i]) = (whole, sums);
            }
        }
        // |h|ⁿ ≤ |h|⁴ Hⁿ⁻⁴.
        nodes.par_iter_mut().for_each(|node| {
            let mean = node.fourth * f64::from(node.radius).powi(DEGREE as i32 - 3);
            node.size = libm::pow(mean, 1.0 / (DEGREE + 1) as f64) as f32;
        });
        Self { nodes, moments }
    }
}

impl Cluster {
    fn around(centroid: DVec3, count: f64) -> Self {
        Self { centroid, count: count as f32, spread: 0.0, size: 0.0, fourth: 0.0, radius: 0.0 }
    }

    fn finish(&mut self, count: f64, fourth: f64, moments: &Coefficients) {
        self.spread = (square_sum(moments) / count) as f32;
        self.fourth = (fourth / count).max(0.0);
    }
}

/// How far the farthest point of a box is.
fn farthest(at: DVec3, low: IVec3, high: IVec3) -> f64 {
    (at - low.as_dvec3()).max(high.as_dvec3() - at).length()
}

/// The active voxels of the 4³ at a place of a block.
fn of_cube<const N: usize>(volume: &Volume<N>, block: u32, place: u16) -> (Cluster, Coefficients) {
    let (mut count, mut sum) = (0.0, DVec3::ZERO);
    for (voxel, _) in cube(volume, block, place) {
        count += 1.0;
        sum += voxel.as_dvec3();
    }
    let mut whole = Cluster::around(sum / count, count);
    let mut moments = ZERO;
    let mut fourth = 0.0;
    for (voxel, value) in cube(volume, block, place) {
        let [red, green, blue] = three(value);
        let h = (whole.centroid - voxel.as_dvec3()).as_vec3();
        for (moment, power) in moments.iter_mut().zip(monomials(h)) {
            let terms = [power, power * red, power * green, power * blue];
            (0..4).for_each(|i| moment[i] += terms[i]);
        }
        let squared = h.length_squared();
        fourth += f64::from(squared * squared);
        whole.radius = whole.radius.max(squared.sqrt());
    }
    whole.finish(count, fourth, &moments);
    (whole, moments)
}

/// Nodes that are one.
fn of_parts(parts: &[Cluster], part_moments: &[Coefficients]) -> (Cluster, Coefficients) {
    let count: f64 = parts.iter().map(|part| f64::from(part.count)).sum();
    let sum: DVec3 = parts.iter().map(|part| f64::from(part.count) * part.centroid).sum();
    let mut whole = Cluster::around(sum / count, count);
    let mut moments = ZERO;
    let mut fourth = 0.0;
    for (part, from) in parts.iter().zip(part_moments) {
        let (step, count) = (whole.centroid - part.centroid, f64::from(part.count));
        shift(&mut moments, from, step);
        fourth += shifted_fourth(count * part.fourth, count, from, step);
        whole.radius = whole.radius.max(step.length() as f32 + part.radius);
    }
    whole.finish(count, fourth, &moments);
    (whole, moments)
}
