//! Colours chosen at random, the same for all of a cell.

use std::sync::Arc;

use super::mix::{Mixer, Turn};
use super::{Colour, ColourSampler, ColourSpace, LinearRgb};
use crate::field::{Aabb, BATCH, Points};

/// Space divided into cells.
pub trait CellIndex: Send + Sync {
    /// The cells that the points lie in.
    fn indices(&self, points: &Points, out: &mut [u32; BATCH]);
}

/// Cubes of one size side by side, one of them centred at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubeLattice {
    /// A cube's edge, world units.
    pub edge: f64,
}

impl CellIndex for CubeLattice {
    /// A hash of the cube's place: two cubes share one rarely, and never neighbours by rule.
    fn indices(&self, points: &Points, out: &mut [u32; BATCH]) {
        for (i, out) in out[..points.len].iter_mut().enumerate() {
            let place = (points.position(i) / self.edge).round().as_i64vec3();
            let hash = place.to_array().iter().fold(0, |hash, part| scrambled(hash ^ *part as u64));
            *out = (hash >> 32) as u32;
        }
    }
}

/// What a cell's colour is chosen from.
#[derive(Clone, Debug, PartialEq)]
pub enum Choice {
    /// One of these. Where there are none, mid grey.
    Palette(Vec<LinearRgb>),
    /// Anything between two colours.
    Range {
        /// One end.
        from: LinearRgb,
        /// The other.
        to: LinearRgb,
        /// Where they are mixed.
        space: ColourSpace,
    },
}

impl Choice {
    /// The colour that a seed chooses for a cell, the same on every machine.
    pub fn pick(&self, seed: u64, cell: u32) -> LinearRgb {
        let hash = scrambled(scrambled(seed) ^ u64::from(cell));
        match self {
            Self::Palette(colours) if colours.is_empty() => [0.18; 3],
            // The upper half of the product is even over the palette.
            Self::Palette(colours) => colours[((u128::from(hash) * colours.len() as u128) >> 64) as usize],
            Self::Range { from, to, space } => {
                let weight = (hash >> 40) as f32 / (1u32 << 24) as f32;
                Mixer::new(*space, Turn::between(*space, *from, *to)).mix(*from, *to, weight)
            }
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

/// A colour a cell.
pub struct ByCell {
    /// Which cell a point lies in.
    pub cells: Arc<dyn CellIndex>,
    /// What the colours are chosen from.
    pub choice: Choice,
    /// Another seed, other colours.
    pub seed: u64,
}

impl Colour for ByCell {
    fn sampler(&self) -> Box<dyn ColourSampler + '_> {
        Box::new(ByCellSampler { colour: self, indices: [0; BATCH] })
    }
}

struct ByCellSampler<'a> {
    colour: &'a ByCell,
    indices: [u32; BATCH],
}

impl ColourSampler for ByCellSampler<'_> {
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [LinearRgb; BATCH]) {
        self.colour.cells.indices(points, &mut self.indices);
        let mut last: Option<(u32, LinearRgb)> = None;
        for (index, out) in self.indices[..points.len].iter().zip(out) {
            let colour = match last {
                Some((cell, colour)) if cell == *index => colour,
                _ => self.colour.choice.pick(self.colour.seed, *index),
            };
            last = Some((*index, colour));
            *out = colour;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, Vec3};

    const THREE: [LinearRgb; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    #[test]
    fn a_palette_is_used_evenly_and_a_seed_changes_it() {
        let choice = Choice::Palette(THREE.to_vec());
        let count = |colour: LinearRgb| (0..30_000).filter(|cell| choice.pick(7, *cell) == colour).count();
        for colour in THREE {
            assert!((9_700..10_300).contains(&count(colour)));
        }
        assert!((0..100).any(|cell| choice.pick(7, cell) != choice.pick(8, cell)));
    }

    #[test]
    fn one_colour_a_cube() {
        let cells = Arc::new(CubeLattice { edge: 0.5 });
        let colour = ByCell { cells, choice: Choice::Palette(THREE.to_vec()), seed: 3 };
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

    #[test]
    fn a_range_stays_between_its_ends() {
        let choice = Choice::Range { from: [0.0; 3], to: [1.0; 3], space: ColourSpace::Rgb };
        let grey: Vec<f32> = (0..1000).map(|cell| choice.pick(1, cell)[0]).collect();
        assert!(grey.iter().all(|value| (0.0..1.0).contains(value)));
        assert!((grey.iter().sum::<f32>() / 1000.0 - 0.5).abs() < 0.03);
    }
}
