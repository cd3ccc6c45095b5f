//! Simplex noise: a slope at each corner of a lattice of tetrahedra, each felt within a ball.
//!
//! Perlin, Noise hardware, 2001; Gustavson, Simplex noise demystified, 2005; the ball's squared radius is 1/2, so that there is no
//! jump where another tetrahedron begins.

use glam::{DVec3, I64Vec3};

use super::hash::{direction, of_cell};
use super::{Noise, numbered};

/// Simplex noise.
#[derive(Clone, Copy, Debug)]
pub struct Simplex {
    /// What it starts from.
    pub seed: u64,
}

/// More than the sum comes to with the worst directions: 0.009289, found by search over a tetrahedron.
const MOST: f64 = 0.0094;

/// More than its slope comes to with the worst directions: 0.072479, found likewise.
const STEEPEST: f64 = 0.0735;

impl Noise for Simplex {
    fn at(&self, position: DVec3) -> (f64, DVec3) {
        let skewed = (position + position.element_sum() / 3.0).floor();
        if !skewed.is_finite() {
            return (f64::NAN, DVec3::NAN);
        }
        let cell = numbered(skewed);
        let within = position - (skewed - skewed.element_sum() / 6.0);
        // Along the greatest offset first: the corners of the tetrahedron that the position is in.
        let DVec3 { x, y, z } = within;
        let [second, third] = match (x >= y, y >= z, x >= z) {
            (true, true, _) => [[1, 0, 0], [1, 1, 0]],
            (true, false, true) => [[1, 0, 0], [1, 0, 1]],
            (true, false, false) => [[0, 0, 1], [1, 0, 1]],
            (false, false, _) => [[0, 0, 1], [0, 1, 1]],
            (false, true, false) => [[0, 1, 0], [0, 1, 1]],
            (false, true, true) => [[0, 1, 0], [1, 1, 0]],
        };
        let (mut value, mut slope) = (0.0, DVec3::ZERO);
        for by in [[0, 0, 0], second, third, [1, 1, 1]].map(I64Vec3::from_array) {
            let corner = by.as_dvec3();
            let offset = within - (corner - corner.element_sum() / 6.0);
            let near = 0.5 - offset.length_squared();
            if near <= 0.0 {
                continue;
            }
            let way = direction(of_cell(cell + by, self.seed));
            let height = way.dot(offset);
            let (cube, fourth) = (near * near * near, near * near * near * near);
            value += fourth * height;
            slope += way * fourth - offset * (8.0 * cube * height);
        }
        ((0.5 + value / (2.0 * MOST)).clamp(0.0, 1.0), slope / (2.0 * MOST))
    }

    fn steepest(&self) -> f64 {
        STEEPEST / (2.0 * MOST)
    }
}
