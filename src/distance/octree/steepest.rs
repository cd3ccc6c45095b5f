//! How steep F may be over cells, from the Bernstein coefficients of its derivatives: a gradient stays in the hull of what
//! the coefficients make up together.
//!
//! Where that says more than 1, which a distance hardly is steeper than, the hulls of the cell's eight octants are looked
//! at: that of the whole takes more than twice as much too much. Cells that need it are looked at several at a time, each
//! in its own lane of the vectors.

use multiversion::multiversion;

use super::patch::{Tensor, greater, rounding_of_slopes};

/// A bound of |∇F| above this is worth looking at octants.
const STEEP: f64 = 1.05;

/// Cells looked at together. Fewer, and the compiler takes loops over them apart.
const LANES: usize = 16;

type Lanes = [f64; LANES];

/// The coefficients of a cubic's two halves, of which they share one.
const HALVED: usize = 7;

/// A derivative's coefficients for several cells: by the place along x, those of y, z and the cell.
type Coefficients = [[f64; 16 * LANES]; 4];

/// Bounds of |∇F| over cells, in the order in which they were added.
pub struct Steepest {
    found: Vec<Found>,
    /// The cells that wait for their octants, and the coefficients of their derivatives.
    waiting: Vec<usize>,
    slopes: Box<[Coefficients; 3]>,
}

struct Found {
    longest_squared: f64,
    rounding: f64,
}

impl Steepest {
    /// Of no cells yet.
    pub fn new() -> Self {
        Self { found: Vec::new(), waiting: Vec::with_capacity(LANES), slopes: Box::new([[[0.0; 16 * LANES]; 4]; 3]) }
    }

    /// Adds a cell or a part of one: its coefficients, those of its derivatives, and the edge of the whole cell.
    pub fn add(&mut self, tensor: &Tensor, slopes: &[Tensor; 3], cell: f64) {
        let longest_squared = longest_squared(slopes);
        if longest_squared > STEEP * STEEP {
            let lane = self.waiting.len();
            self.waiting.push(self.found.len());
            for (all, slopes) in self.slopes.iter_mut().zip(slopes) {
                let lanes = all.as_flattened_mut().iter_mut().skip(lane).step_by(LANES);
                lanes.zip(slopes).for_each(|(to, slope)| *to = *slope);
            }
        }
        self.found.push(Found { longest_squared, rounding: rounding_of_slopes(tensor, cell) });
        if self.waiting.len() == LANES {
            self.look_at_octants();
        }
    }

    fn look_at_octants(&mut self) {
        let longest_squared = longest_squared_in_octants(&self.slopes);
        for (cell, longest_squared) in self.waiting.drain(..).zip(longest_squared) {
            self.found[cell].longest_squared = longest_squared;
        }
    }

    /// The bounds; none is left.
    pub fn take(&mut self) -> impl Iterator<Item = f64> {
        if !self.waiting.is_empty() {
            self.look_at_octants();
        }
        self.found.drain(..).map(|Found { longest_squared, rounding }| longest_squared.sqrt() + rounding)
    }
}

#[multiversion(targets = "simd")]
fn longest_squared([x, y, z]: &[Tensor; 3]) -> f64 {
    let mut longest = [0.0; LANES];
    for first in (0..64).step_by(LANES) {
        for lane in 0..LANES {
            let [x, y, z] = [x[first + lane], y[first + lane], z[first + lane]];
            longest[lane] = greater(x * x + y * y + z * z, longest[lane]);
        }
    }
    longest.into_iter().fold(0.0, greater)
}

/// Of the octants' coefficients, by cell.
#[multiversion(targets = "simd")]
fn longest_squared_in_octants(slopes: &[Coefficients; 3]) -> Lanes {
    let mut squares = [[[[0.0; LANES]; HALVED]; HALVED]; HALVED];
    let mut along_x = [[0.0; 16 * LANES]; HALVED];
    let mut along_y = [[0.0; 4 * LANES]; HALVED];
    for [a, b, c, d] in slopes {
        for n in 0..16 * LANES {
            let halves = halved([a[n], b[n], c[n], d[n]]);
            for i in 0..HALVED {
                along_x[i][n] = halves[i];
            }
        }
        for (along_x, squares) in along_x.iter().zip(&mut squares) {
            let [a, b, c, d] = quarters::<{ 4 * LANES }>(along_x);
            for n in 0..4 * LANES {
                let halves = halved([a[n], b[n], c[n], d[n]]);
                for i in 0..HALVED {
                    along_y[i][n] = halves[i];
                }
            }
            for (along_y, squares) in along_y.iter().zip(squares) {
                let [a, b, c, d] = quarters::<LANES>(along_y);
                for n in 0..LANES {
                    let halves = halved([a[n], b[n], c[n], d[n]]);
                    for i in 0..HALVED {
                        squares[i][n] += halves[i] * halves[i];
                    }
                }
            }
        }
    }
    let mut longest = [0.0; LANES];
    for squares in squares.as_flattened().as_flattened() {
        for lane in 0..LANES {
            longest[lane] = greater(squares[lane], longest[lane]);
        }
    }
    longest
}

#[inline(always)]
fn quarters<const N: usize>(numbers: &[f64]) -> [&[f64; N]; 4] {
    let (chunks, _) = numbers.as_chunks::<N>();
    [&chunks[0], &chunks[1], &chunks[2], &chunks[3]]
}

/// The coefficients of both halves of a cubic, by de Casteljau.
#[inline(always)]
fn halved([a, b, c, d]: [f64; 4]) -> [f64; HALVED] {
    let [ab, bc, cd] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + d)];
    let [abc, bcd] = [0.5 * (ab + bc), 0.5 * (bc + cd)];
    [a, ab, abc, 0.5 * (abc + bcd), bcd, cd, d]
}

#[cfg(test)]
mod tests {
    use super::super::patch::{Jet, Patch, polynomial, restrict, slopes};
    use super::*;

    /// More cells than are looked at together, steep ones among flat ones.
    #[test]
    fn the_steepest_slope_is_that_of_the_octants() {
        let mut all = Steepest::new();
        let mut cells = Vec::new();
        for cell in 0..3 * LANES + 1 {
            let edge = 0.3 + 0.02 * cell as f64;
            let scale = if cell % 3 == 1 { 0.01 } else { 1.0 };
            let at = |p| polynomial(p).map(|number| scale * number);
            let corner = |corner: usize| {
                let place: [f64; 3] = std::array::from_fn(|axis| edge * f64::from(corner as u32 >> (2 - axis) & 1));
                at(place)
            };
            let tensor = Patch { corners: std::array::from_fn(corner), edge }.bernstein();
            all.add(&tensor, &slopes(&tensor, [edge; 3]), edge);
            cells.push((tensor, edge, scale));
        }
        let found: Vec<f64> = all.take().collect();
        assert_eq!(found.len(), cells.len());
        for (steepest, (tensor, edge, scale)) in found.into_iter().zip(cells) {
            // The same by blossoming, and the rounding that a cell's values allow for.
            let whole = longest_squared(&slopes(&tensor, [edge; 3])).sqrt();
            let octants = (0..8).map(|octant| {
                let lo: [f64; 3] = std::array::from_fn(|axis| 0.5 * f64::from(octant as u32 >> (2 - axis) & 1));
                longest_squared(&slopes(&restrict(&tensor, lo, lo.map(|lo| lo + 0.5)), [0.5 * edge; 3])).sqrt()
            });
            assert_eq!(whole > STEEP, scale == 1.0, "{whole}");
            let hull = if whole > STEEP { octants.fold(0.0, f64::max) } else { whole };
            let want = hull + rounding_of_slopes(&tensor, edge);
            assert!((steepest - want).abs() < 1e-12 * want, "{steepest} for {want}");
            for place in 0..1000 {
                let p = std::array::from_fn(|axis| edge / 9.0 * f64::from(place / 10_i32.pow(axis as u32) % 10));
                let [_, z, y, _, x, ..]: Jet = polynomial(p);
                assert!(scale * (x * x + y * y + z * z).sqrt() < steepest, "at {p:?}");
            }
        }
        assert_eq!(all.take().count(), 0);
    }
}
