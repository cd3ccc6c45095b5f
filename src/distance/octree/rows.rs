//! Blocks of voxels that stand in rows along z of the octree: what is the same all along a row is worked out once.
//!
//! Answers have the same bits as those of points one by one.

use glam::Vec4;
use multiversion::multiversion;

use super::kernel::{AlongX, Located, Polynomial, by_y, cubic, cubic_and_slope, in_leaf, one_over_edge};
use crate::field::{BATCH, Points};
use crate::grid::BLOCK_EDGE;

/// Points of a row: the voxels of a block along z.
pub const ROW: usize = BLOCK_EDGE as usize;
/// Rows of a block.
pub const ROWS: usize = BATCH / ROW;

/// The offsets of a block's voxels: x and y of each row, z of each place in a row.
pub struct Rows {
    /// By row.
    pub x: [f32; ROWS],
    /// By row.
    pub y: [f32; ROWS],
    /// By place in a row.
    pub z: [f32; ROW],
}

impl Rows {
    /// `None` where points are no block's voxels, or the block was turned about another axis than z.
    #[inline]
    pub fn of(points: &Points) -> Option<Self> {
        (points.len == BATCH && stand_in_rows(points)).then(|| Self {
            x: std::array::from_fn(|row| points.x[row * ROW]),
            y: std::array::from_fn(|row| points.y[row * ROW]),
            z: std::array::from_fn(|lane| points.z[lane]),
        })
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2", "x86_64+sse4.1"))]
fn stand_in_rows(points: &Points) -> bool {
    let mut differs = 0;
    for row in (0..BATCH).step_by(ROW) {
        for lane in 0..ROW {
            differs |= points.x[row + lane].to_bits() ^ points.x[row].to_bits();
            differs |= points.y[row + lane].to_bits() ^ points.y[row].to_bits();
            differs |= points.z[row + lane].to_bits() ^ points.z[lane].to_bits();
        }
    }
    differs == 0
}

/// Works out `t` along z and `inverse_edge` from `leaf` and `level`, which stand by point, and `at` and `cell`, which stand
/// as in [`Rows`]; `inverse_step` is one over a smallest cell's edge.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2", "x86_64+sse4.1"))]
pub fn place_in_leaves(located: &mut Located, inverse_step: f64) {
    let Located { at: [_, _, at], cell: [_, _, cell], t: [_, _, t], level, inverse_edge, .. } = located;
    for row in (0..BATCH).step_by(ROW) {
        for lane in 0..ROW {
            let level = level[row + lane];
            t[row + lane] = in_leaf(at[lane], cell[lane], level);
            inverse_edge[row + lane] = (one_over_edge(level) * inverse_step) as f32;
        }
    }
}

/// F, ∂x, ∂y, ∂z: what x and y leave of a cell's polynomial serves all points of a row that lie in it. See
/// [`place_in_leaves`] for what stands where.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2", "x86_64+sse4.1"))]
pub fn gradients(polynomials: &[Polynomial], located: &Located, out: [&mut [f32; BATCH]; 4]) {
    // Lanes spelt out by four: a loop over a whole row would be taken apart into single numbers.
    const LANES: [Vec4; 2] = [Vec4::new(0.0, 1.0, 2.0, 3.0), Vec4::new(4.0, 5.0, 6.0, 7.0)];
    // The steps along x of all cells of a row come first: see those of points in any cells.
    let mut along_x: [[AlongX; 2]; ROW] = [[[0.0; 16]; 2]; ROW];
    let (mut starts, mut along_y) = ([0; ROW + 1], [0.0; ROW]);
    let [value, dx, dy, dz] = out;
    for row in 0..ROWS {
        let first = row * ROW;
        let leaves = &located.leaf[first..first + ROW];
        let mut cells = 0;
        for lane in 0..ROW {
            if lane == 0 || leaves[lane] != leaves[lane - 1] {
                starts[cells] = lane;
                cells += 1;
            }
        }
        starts[cells] = ROW;
        for cell in 0..cells {
            let start = starts[cell];
            let level = located.level[first + start];
            let [x, y] = [0, 1].map(|axis| in_leaf(located.at[axis][row], located.cell[axis][row], level));
            polynomials[leaves[start] as usize].along_x_and_slopes(x, &mut along_x[cell]);
            along_y[cell] = y;
        }
        let halves = |numbers: &[f32; BATCH]| [0, 4].map(|lane| Vec4::from_slice(&numbers[first + lane..]));
        let z = halves(&located.t[2]);
        let mut found = [[Vec4::ZERO; 4]; 2];
        for cell in 0..cells {
            let ([values, slopes], y) = (&along_x[cell], along_y[cell]);
            let (by_z, dy) = cubic_and_slope(by_y(values), y);
            let [by_z, dx, dy] = [splat_each(by_z), splat_each(cubic(by_y(slopes), y)), splat_each(dy)];
            let (start, end) = (starts[cell], starts[cell + 1]);
            for half in start / 4..=(end - 1) / 4 {
                let (sum, slope) = cubic_and_slope(by_z, z[half]);
                let here = [sum, cubic(dx, z[half]), cubic(dy, z[half]), slope];
                // Taken from here on, of which the next cell takes its own.
                let lanes = LANES[half].cmpge(Vec4::splat(start as f32));
                for n in 0..4 {
                    found[half][n] = Vec4::select(lanes, here[n], found[half][n]);
                }
            }
        }
        let inverse_edge = halves(&located.inverse_edge);
        for half in 0..2 {
            let [sum, by_x, by_y, by_z] = found[half];
            let at = first + 4 * half;
            sum.write_to_slice(&mut value[at..]);
            (by_x * inverse_edge[half]).write_to_slice(&mut dx[at..]);
            (by_y * inverse_edge[half]).write_to_slice(&mut dy[at..]);
            (by_z * inverse_edge[half]).write_to_slice(&mut dz[at..]);
        }
    }
}

#[inline(always)]
fn splat_each(numbers: Vec4) -> [Vec4; 4] {
    let [a, b, c, d] = numbers.to_array();
    [Vec4::splat(a), Vec4::splat(b), Vec4::splat(c), Vec4::splat(d)]
}
