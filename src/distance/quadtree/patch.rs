//! One cell of the plane: a bicubic by its Bernstein coefficients.

use crate::distance::octree::patch::cut;
use crate::field::Interval;

/// F, ∂y, ∂x and ∂xy at a corner.
pub type Jet = [f64; 4];

/// A bicubic over \[0, 1\]², its coefficients by x and y.
#[derive(Clone, Copy, Debug)]
pub struct Patch(pub [[f64; 4]; 4]);

/// The values or slopes of the four cubic Bernstein polynomials at a place.
type Weights = [f64; 4];

fn weights(t: f64) -> Weights {
    let s = 1.0 - t;
    [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
}

fn slopes(t: f64) -> Weights {
    let s = 1.0 - t;
    [-3.0 * s * s, 3.0 * s * s - 6.0 * s * t, 6.0 * s * t - 3.0 * t * t, 3.0 * t * t]
}

impl Patch {
    /// The bicubic with these jets at the corners of a cell: the one at (x, y) = (0, 0), then (0, 1), (1, 0), (1, 1).
    pub fn hermite(corners: [&Jet; 4], edge: f64) -> Self {
        // Along a line a cubic has its ends, and points that stand a third of the edge along the slopes at them.
        let third = edge / 3.0;
        let side = |place: usize| if place < 2 { (0, place) } else { (1, 3 - place) };
        let along = |(end, inner): (usize, usize)| [1.0, [third, -third][end]][inner];
        let coefficient = |i: usize, j: usize| {
            let (x, y) = (side(i), side(j));
            let [value, by_y, by_x, by_xy] = *corners[2 * x.0 + y.0];
            match (x.1, y.1) {
                (0, 0) => value,
                (0, _) => value + along(y) * by_y,
                (_, 0) => value + along(x) * by_x,
                _ => value + along(x) * by_x + along(y) * by_y + along(x) * along(y) * by_xy,
            }
        };
        Self(std::array::from_fn(|i| std::array::from_fn(|j| coefficient(i, j))))
    }

    /// The bilinear function of these values at the corners, in the same order.
    pub fn bilinear([near, up, right, far]: [f64; 4]) -> Self {
        let mix = |a: f64, b: f64, share: usize| a + (b - a) * share as f64 / 3.0;
        Self(std::array::from_fn(|i| std::array::from_fn(|j| mix(mix(near, up, j), mix(right, far, j), i))))
    }

    fn sum(&self, x: Weights, y: Weights) -> f64 {
        let row = |i: usize| (0..4).fold(0.0, |sum, j| sum + y[j] * self.0[i][j]);
        (0..4).fold(0.0, |sum, i| sum + x[i] * row(i))
    }

    /// F and its derivatives at a place in a cell of an edge.
    pub fn jet(&self, [x, y]: [f64; 2], edge: f64) -> Jet {
        let ([wx, wy], [sx, sy]) = ([x, y].map(weights), [x, y].map(slopes));
        let numbers = [self.sum(wx, wy), self.sum(wx, sy), self.sum(sx, wy), self.sum(sx, sy)];
        [numbers[0], numbers[1] / edge, numbers[2] / edge, numbers[3] / (edge * edge)]
    }

    /// The hull of F over a part of the cell: a polynomial stays within its coefficients.
    pub fn range(&self, low: [f64; 2], high: [f64; 2]) -> Interval {
        let mut part = self.0.map(|line| cut(line, low[1], high[1]));
        for j in 0..4 {
            let line = cut(std::array::from_fn(|i| part[i][j]), low[0], high[0]);
            (0..4).for_each(|i| part[i][j] = line[i]);
        }
        let all = part.as_flattened();
        all.iter().fold(Interval::new(all[0], all[0]), |range, &number| range.union(Interval::new(number, number)))
    }
}
