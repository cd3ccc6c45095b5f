//! The inner loops: value and gradient of a cell's polynomial in `f32`, one point at a time over coefficients side by
//! side, or many points at a time.
//!
//! Both ways do the same operations in the same order, so a point's answer has the same bits whichever way its
//! batch went, and at any vector width (no fused multiply-add).

use std::array::from_fn;
use std::ops::{Add, Mul};

use glam::{Mat4, Vec4};
use multiversion::multiversion;

use super::patch::Patch;
use crate::field::BATCH;

/// A cell's polynomial over its \[0, 1\]³: by the powers of x and of y the coefficients of 1, z, z² and z³. It fills four
/// lines of a cache.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Polynomial([[[f32; 4]; 4]; 4]);

/// What is left of each polynomial once x is given: by the power of y the coefficients of 1, z, z² and z³.
type AlongX = [f32; 16];

impl Polynomial {
    /// That of a patch.
    pub fn of(patch: &Patch) -> Self {
        let mut coefficients = [[[0.0; 4]; 4]; 4];
        for (to, from) in coefficients.as_flattened_mut().as_flattened_mut().iter_mut().zip(patch.powers()) {
            *to = from as f32;
        }
        Self(coefficients)
    }

    /// What x leaves of it.
    #[inline(always)]
    fn along_x(&self, x: f32, out: &mut AlongX) {
        let [a, b, c, d] = self.0.each_ref().map(|by_y| by_y.as_flattened());
        for n in 0..16 {
            out[n] = cubic([a[n], b[n], c[n], d[n]], x);
        }
    }

    /// The same, and its slopes.
    #[inline(always)]
    fn along_x_and_slopes(&self, x: f32, [values, slopes]: &mut [AlongX; 2]) {
        let [a, b, c, d] = self.0.each_ref().map(|by_y| by_y.as_flattened());
        for n in 0..16 {
            (values[n], slopes[n]) = cubic_and_slope([a[n], b[n], c[n], d[n]], x);
        }
    }
}

#[inline(always)]
fn by_y(along_x: &AlongX) -> [Vec4; 4] {
    from_fn(|j| Vec4::from_slice(&along_x[4 * j..]))
}

/// F.
#[inline(always)]
fn value_at(along_x: &AlongX, [y, z]: [f32; 2]) -> f32 {
    cubic(cubic(by_y(along_x), y).to_array(), z)
}

/// F, ∂x, ∂y, ∂z, the derivatives by places in the cell.
#[inline(always)]
fn gradient_at([values, slopes]: &[AlongX; 2], [y, z]: [f32; 2]) -> [f32; 4] {
    let (value, dy) = cubic_and_slope(by_y(values), y);
    let dx = cubic(by_y(slopes), y);
    // F, ∂x and ∂y side by side, by the powers of z.
    let by_z = Mat4::from_cols(value, dx, dy, Vec4::ZERO).transpose();
    let (sums, slopes) = cubic_and_slope([by_z.x_axis, by_z.y_axis, by_z.z_axis, by_z.w_axis], z);
    [sums.x, sums.y, sums.z, slopes.x]
}

/// a + t(b + t(c + t·d)), of numbers or of several side by side.
#[inline(always)]
fn cubic<T: Copy + Add<Output = T> + Mul<S, Output = T>, S: Copy>([a, b, c, d]: [T; 4], t: S) -> T {
    a + (b + (c + d * t) * t) * t
}

/// The same, and its slope.
#[inline(always)]
fn cubic_and_slope<T: Copy + Add<Output = T> + Mul<S, Output = T>, S: Copy>([a, b, c, d]: [T; 4], t: S) -> (T, T) {
    let highest = d * t;
    let last = c + highest;
    let first = b + last * t;
    (a + first * t, first + (last + highest) * t)
}

/// Points whose polynomials are worked out together.
const AT_A_TIME: usize = 16;

/// A batch of points in cells.
pub struct Located {
    /// Positions on the lattice of smallest cells, by axis, brought into the root.
    pub at: [[f64; BATCH]; 3],
    /// The smallest cells that hold them.
    pub cell: [[i32; BATCH]; 3],
    /// Places in the leaf, \[0, 1\] on each axis.
    pub t: [[f32; BATCH]; 3],
    /// The leaf.
    pub leaf: [u32; BATCH],
    /// How often the leaf's edge doubles that of a smallest cell.
    pub level: [u32; BATCH],
    /// One over the leaf's edge, in world units.
    pub inverse_edge: [f32; BATCH],
}

/// Where a batch lies: the least and greatest smallest cell by axis, and whether some points are out of the root.
pub struct Extent {
    /// The least cell.
    pub low: [i32; 3],
    /// The greatest.
    pub high: [i32; 3],
    /// Whether a point is out of the root.
    pub outside: bool,
}

/// 2⁵²: added to a whole number from 0 on, it leaves that number in the last bits. (A cast to an integer, which has to
/// look after what is no number, is one for each lane.)
const WHOLE: f64 = (1_u64 << 52) as f64;

/// Works out `at` and `cell`: `base + offset·inverse` along each axis, of as many as there are, in a root of `size`
/// smallest cells.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2", "x86_64+sse4.1"))]
pub fn place(offsets: [&[f32]; 3], base: [f64; 3], inverse: f64, size: i32, located: &mut Located) -> Extent {
    let mut extent = Extent { low: [i32::MAX; 3], high: [i32::MIN; 3], outside: false };
    let top = f64::from(size);
    for axis in 0..3 {
        let len = offsets[axis].len();
        let (at, cell) = (&mut located.at[axis][..len], &mut located.cell[axis][..len]);
        let (mut low, mut high, mut outside) = (i32::MAX, i32::MIN, 0);
        for ((at, cell), offset) in at.iter_mut().zip(cell).zip(offsets[axis]) {
            let wanted = base[axis] + f64::from(*offset) * inverse;
            let place = if wanted > 0.0 { wanted } else { 0.0 };
            let place = if place < top { place } else { top };
            outside |= i32::from(place != wanted);
            *at = place;
            *cell = ((place.floor() + WHOLE).to_bits() as i32).min(size - 1);
            low = low.min(*cell);
            high = high.max(*cell);
        }
        extent.low[axis] = low;
        extent.high[axis] = high;
        extent.outside |= outside != 0;
    }
    extent
}

/// As many lanes as whole vectors of so many points have: batches may be of a few.
fn lanes(len: usize) -> usize {
    len.next_multiple_of(16).min(BATCH)
}

/// Works out `t` where all of so many points lie in one leaf.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2", "x86_64+sse4.1"))]
pub fn place_in_cell(located: &mut Located, origin: [i32; 3], size: i32, len: usize) {
    let scale = 1.0 / f64::from(size);
    for axis in 0..3 {
        let origin = f64::from(origin[axis]);
        for (t, at) in located.t[axis].iter_mut().zip(&located.at[axis]).take(lanes(len)) {
            *t = ((at - origin) * scale) as f32;
        }
    }
}

/// 2⁻ˡᵉᵛᵉˡ, by the bits of its exponent.
#[inline(always)]
fn one_over_edge(level: u32) -> f64 {
    f64::from_bits(u64::from(1023 - level) << 52)
}

/// Where in a leaf, \[0, 1\], is what lies in one of its smallest cells.
#[inline(always)]
fn in_leaf(at: f64, cell: i32, level: u32) -> f32 {
    ((at - f64::from(cell >> level << level)) * one_over_edge(level)) as f32
}

/// Works out `t` and `inverse_edge` of so many points from `cell` and `level`; `inverse_step` is one over a smallest cell's
/// edge.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2", "x86_64+sse4.1"))]
pub fn place_in_leaves(located: &mut Located, inverse_step: f64, len: usize) {
    let Located { at, cell, t, level, inverse_edge, .. } = located;
    for n in 0..lanes(len) {
        for axis in 0..3 {
            t[axis][n] = in_leaf(at[axis][n], cell[axis][n], level[n]);
        }
        inverse_edge[n] = (one_over_edge(level[n]) * inverse_step) as f32;
    }
}

// At points in any cells, the steps along x of some come first, then the rest of theirs: kept in memory between, the
// compiler takes all sixteen numbers of a step side by side.

/// Values at points in any cells, as many as `out` holds.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2", "x86_64+sse4.1"))]
pub fn values(polynomials: &[Polynomial], located: &Located, out: &mut [f32]) {
    let len = out.len().min(BATCH);
    let mut along_x = [[0.0; 16]; AT_A_TIME];
    for first in (0..len).step_by(AT_A_TIME) {
        let points = first..len.min(first + AT_A_TIME);
        for (i, along_x) in points.clone().zip(&mut along_x) {
            polynomials[located.leaf[i] as usize].along_x(located.t[0][i], along_x);
        }
        for (i, along_x) in points.zip(&along_x) {
            out[i] = value_at(along_x, [located.t[1][i], located.t[2][i]]);
        }
    }
}

/// Values and gradients at points in any cells: F, ∂x, ∂y, ∂z at the first `len`.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2", "x86_64+sse4.1"))]
pub fn gradients(polynomials: &[Polynomial], located: &Located, out: [&mut [f32; BATCH]; 4], len: usize) {
    let [value, dx, dy, dz] = out;
    let len = len.min(BATCH);
    let mut along_x = [[[0.0; 16]; 2]; AT_A_TIME];
    for first in (0..len).step_by(AT_A_TIME) {
        let points = first..len.min(first + AT_A_TIME);
        for (i, along_x) in points.clone().zip(&mut along_x) {
            polynomials[located.leaf[i] as usize].along_x_and_slopes(located.t[0][i], along_x);
        }
        for (i, along_x) in points.zip(&along_x) {
            let inverse_edge = located.inverse_edge[i];
            let [f, by_x, by_y, by_z] = gradient_at(along_x, [located.t[1][i], located.t[2][i]]);
            (value[i], dx[i], dy[i], dz[i]) = (f, by_x * inverse_edge, by_y * inverse_edge, by_z * inverse_edge);
        }
    }
}

/// Values at so many points that all lie in one cell; entries of `out` past them are unspecified.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2", "x86_64+sse4.1"))]
pub fn values_in_cell(polynomial: &Polynomial, t: &[[f32; BATCH]; 3], out: &mut [f32; BATCH], len: usize) {
    let Polynomial(c) = polynomial;
    for n in 0..lanes(len) {
        let [x, y, z] = [t[0][n], t[1][n], t[2][n]];
        // Loops: closures within closures are not inlined here.
        let mut by_z = [0.0; 4];
        for k in 0..4 {
            let mut along_x = [0.0; 4];
            for j in 0..4 {
                along_x[j] = cubic([c[0][j][k], c[1][j][k], c[2][j][k], c[3][j][k]], x);
            }
            by_z[k] = cubic(along_x, y);
        }
        out[n] = cubic(by_z, z);
    }
}

/// Values and gradients at so many points that all lie in one cell, of an edge of 1/`inverse_edge` world units; entries of
/// `out` past them are unspecified.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2", "x86_64+sse4.1"))]
pub fn gradients_in_cell(
    polynomial: &Polynomial,
    inverse_edge: f32,
    t: &[[f32; BATCH]; 3],
    out: [&mut [f32; BATCH]; 4],
    len: usize,
) {
    let Polynomial(c) = polynomial;
    let [value, dx, dy, dz] = out;
    for n in 0..lanes(len) {
        let [x, y, z] = [t[0][n], t[1][n], t[2][n]];
        let (mut values, mut by_x, mut by_y) = ([0.0; 4], [0.0; 4], [0.0; 4]);
        for k in 0..4 {
            let (mut along_x, mut slopes) = ([0.0; 4], [0.0; 4]);
            for j in 0..4 {
                (along_x[j], slopes[j]) = cubic_and_slope([c[0][j][k], c[1][j][k], c[2][j][k], c[3][j][k]], x);
            }
            (values[k], by_y[k]) = cubic_and_slope(along_x, y);
            by_x[k] = cubic(slopes, y);
        }
        let (sum, slope) = cubic_and_slope(values, z);
        value[n] = sum;
        dx[n] = cubic(by_x, z) * inverse_edge;
        dy[n] = cubic(by_y, z) * inverse_edge;
        dz[n] = slope * inverse_edge;
    }
}
