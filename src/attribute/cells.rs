//! Values chosen at random, the same for all of a cell.

use std::sync::Arc;

use glam::DVec3;

use super::mix::Mix;
use super::{Attribute, Sampler, around};
use crate::field::{Aabb, BATCH, Field, Interval, Points};

/// Space divided into cells.
pub trait CellIndex: Send + Sync {
    /// The cells that the points lie in.
    fn indices(&self, points: &Points, out: &mut [u32; BATCH]);
}

/// Cubes of one size side by side, one of them centred at the origin.
///
/// Where a solid's surface lies in the face between two cubes, its points are a rounding error off to either side;
/// they belong to the cube whose middle is deeper inside.
#[derive(Clone)]
pub struct CubeLattice {
    /// A cube's edge, world units.
    pub edge: f64,
    /// The solid, positive inside.
    pub solid: Arc<dyn Field>,
    /// How near to a face, in world units, points belong to either cube.
    pub tolerance: f64,
}

impl CellIndex for CubeLattice {
    /// A hash of the cube's place: two cubes share one rarely, and never neighbours by rule.
    fn indices(&self, points: &Points, out: &mut [u32; BATCH]) {
        for (i, out) in out[..points.len].iter_mut().enumerate() {
            let place = self.cube_at(points.position(i) / self.edge).as_i64vec3();
            let hash = place.to_array().iter().fold(0, |hash, part| scrambled(hash ^ *part as u64));
            *out = (hash >> 32) as u32;
        }
    }
}

impl CubeLattice {
    /// The cube of a position, both in edges.
    pub fn cube_at(&self, position: DVec3) -> DVec3 {
        let cube = position.round();
        let off = position - cube;
        let near_face = |off: f64| (0.5 - off.abs()) * self.edge < self.tolerance;
        let beyond = DVec3::from_array(off.to_array().map(|off| if near_face(off) { off.signum() } else { 0.0 }));
        if beyond == DVec3::ZERO {
            return cube;
        }
        let mut cubes = [cube; 8];
        let mut count = 1;
        for axis in DVec3::AXES {
            let step = beyond * axis;
            if step != DVec3::ZERO {
                for i in 0..count {
                    cubes[count + i] = cubes[i] + step;
                }
                count *= 2;
            }
        }
        let cubes = &mut cubes[..count];
        // The same order from whichever cube it is seen, so that equals are decided alike.
        cubes.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).unwrap_or(std::cmp::Ordering::Equal));
        let depth = |cube: &DVec3| self.solid.reference(*cube * self.edge);
        let deeper = |best: (f64, DVec3), cube: DVec3| {
            let depth = depth(&cube);
            if depth > best.0 { (depth, cube) } else { best }
        };
        let first = (depth(&cubes[0]), cubes[0]);
        cubes[1..].iter().copied().fold(first, deeper).1
    }
}

/// What a cell's value is chosen from.
#[derive(Clone, Debug, PartialEq)]
pub enum Choice<const N: usize, M> {
    /// One of these. Where there are none, mid grey: 0.18 of each number.
    Palette(Vec<[f32; N]>),
    /// Anything between two values.
    Range {
        /// One end.
        from: [f32; N],
        /// The other.
        to: [f32; N],
        /// How they are mixed.
        mix: M,
    },
}

impl<const N: usize, M: Mix<N>> Choice<N, M> {
    /// The value that a seed chooses for a cell, the same on every machine.
    pub fn pick(&self, seed: u64, cell: u32) -> [f32; N] {
        let hash = scrambled(scrambled(seed) ^ u64::from(cell));
        match self {
            Self::Palette(values) if values.is_empty() => [0.18; N],
            // The upper half of the product is even over the palette.
            Self::Palette(values) => values[((u128::from(hash) * values.len() as u128) >> 64) as usize],
            Self::Range { from, to, mix } => {
                let weight = (hash >> 40) as f32 / (1u32 << 24) as f32;
                mix.mix(*from, *to, weight)
            }
        }
    }
}

impl<const N: usize, M: Mix<N>> Choice<N, M> {
    /// Bounds of all that may be chosen.
    fn bounds(&self) -> [Interval; N] {
        let one = |value: &[f32; N]| around([*value].into_iter());
        match self {
            Self::Palette(values) if values.is_empty() => one(&[0.18; N]),
            Self::Palette(values) => around(values.iter().copied()),
            Self::Range { from, to, mix } => mix.bounds(one(from), one(to), Interval::new(0.0, 1.0)),
        }
    }
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014).
fn scrambled(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A value a cell.
pub struct ByCell<const N: usize, M> {
    /// Which cell a point lies in.
    pub cells: Arc<dyn CellIndex>,
    /// What the values are chosen from.
    pub choice: Choice<N, M>,
    /// Another seed, other values.
    pub seed: u64,
}

impl<const N: usize, M: Mix<N>> Attribute<N> for ByCell<N, M> {
    fn sampler(&self) -> Box<dyn Sampler<N> + '_> {
        Box::new(ByCellSampler { by_cell: self, indices: [0; BATCH] })
    }
}

struct ByCellSampler<'a, const N: usize, M> {
    by_cell: &'a ByCell<N, M>,
    indices: [u32; BATCH],
}

impl<const N: usize, M: Mix<N>> Sampler<N> for ByCellSampler<'_, N, M> {
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [[f32; N]; BATCH]) {
        self.by_cell.cells.indices(points, &mut self.indices);
        let mut start = 0;
        for run in self.indices[..points.len].chunk_by(|a, b| a == b) {
            out[start..start + run.len()].fill(self.by_cell.choice.pick(self.by_cell.seed, run[0]));
            start += run.len();
        }
    }

    fn bounds(&mut self, _region: &Aabb) -> [Interval; N] {
        self.by_cell.choice.bounds()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attribute::{LinearRgb, Straight};
    use crate::field::{Expression, Graph};
    use glam::{DVec3, Vec3};

    /// A cube around the origin.
    fn block(edge: f64) -> Arc<dyn Field> {
        let mut graph = Graph::new();
        let node = graph.cuboid(DVec3::splat(edge));
        Arc::new(Expression::new(&graph, node))
    }

    const THREE: [LinearRgb; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    #[test]
    fn a_palette_is_used_evenly_and_a_seed_changes_it() {
        let choice = Choice::<3, Straight>::Palette(THREE.to_vec());
        let count = |colour: LinearRgb| (0..30_000).filter(|cell| choice.pick(7, *cell) == colour).count();
        for colour in THREE {
            assert!((9_700..10_300).contains(&count(colour)));
        }
        assert!((0..100).any(|cell| choice.pick(7, cell) != choice.pick(8, cell)));
    }

    #[test]
    fn one_colour_a_cube() {
        let cells = Arc::new(CubeLattice { edge: 0.5, solid: block(9.0), tolerance: 0.0 });
        let colour = ByCell { cells, choice: Choice::<3, Straight>::Palette(THREE.to_vec()), seed: 3 };
        let mut points = Points::new(DVec3::new(-10.0, 3.0, 0.5));
        (0..BATCH).for_each(|i| points.push(Vec3::splat(i as f32 * 0.01)));
        let mut out = [[0.0; 3]; BATCH];
        colour.sampler().sample(&points, &mut out);
        let cube = |i: usize| (points.position(i) / 0.5).round();
        for i in 1..BATCH {
            assert!(THREE.contains(&out[i]));
            assert!(cube(i) != cube(i - 1) || out[i] == out[i - 1]);
        }
        assert!((1..BATCH).any(|i| out[i] != out[0]));
    }

    /// A cube of edge 1 in a lattice of 0.2: its faces, edges and corners all lie between cubes of the lattice.
    #[test]
    fn a_surface_between_cubes_belongs_to_those_inside() {
        let lattice = CubeLattice { edge: 0.2, solid: block(1.0), tolerance: 1e-4 };
        let index_at = |position: DVec3| {
            let mut points = Points::new(position);
            points.push(Vec3::ZERO);
            let mut out = [0; BATCH];
            lattice.indices(&points, &mut out);
            out[0]
        };
        let inner = index_at(DVec3::new(0.4, 0.38, 0.4));
        for wobble in [-1e-6, 0.0, 1e-6] {
            let at = 0.5 + wobble;
            assert_eq!(index_at(DVec3::new(at, 0.38, 0.42)), inner);
            assert_eq!(index_at(DVec3::new(at, 0.5 - wobble, 0.42)), inner);
            assert_eq!(index_at(DVec3::new(at, 0.5 - wobble, 0.5)), inner);
            assert_ne!(index_at(DVec3::new(at, 0.18, 0.42)), inner);
        }
    }

    #[test]
    fn a_range_stays_between_its_ends() {
        let choice = Choice::Range { from: [0.0; 3], to: [1.0; 3], mix: Straight };
        let grey: Vec<f32> = (0..1000).map(|cell| choice.pick(1, cell)[0]).collect();
        assert!(grey.iter().all(|value| (0.0..1.0).contains(value)));
        assert!((grey.iter().sum::<f32>() / 1000.0 - 0.5).abs() < 0.03);
    }
}
