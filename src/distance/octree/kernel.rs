//! The inner loops: value and gradient of a Hermite patch in `f32`, one point at a time over the numbers of the
//! corners, or many points at a time in one cell.
//!
//! Both ways do the same operations in the same order, so a point's answer has the same bits whichever way its
//! batch went, and at any vector width (no fused multiply-add).

use std::ops::{Add, Mul, Neg, Sub};

use glam::{Mat4, Vec4};
use multiversion::multiversion;

use crate::field::{BATCH, Points};

/// The eight numbers of a corner: F, Fz, Fy, Fyz, then Fx, Fxz, Fxy, Fxyz.
pub type Numbers = [Vec4; 2];

/// The cubic Hermite basis along one axis: value and slope of the near corner, then of the far one. Slopes count
/// in world units.
type Weights = [f32; 4];

/// Of a number along one axis, or of several axes side by side.
#[inline(always)]
fn basis<T: Copy + Mul<Output = T> + Neg<Output = T>>(t: T, edge: f32) -> [T; 4]
where
    f32: Add<T, Output = T> + Sub<T, Output = T> + Mul<T, Output = T>,
{
    let s = 1.0_f32 - t;
    let (tt, ss) = (t * t, s * s);
    [(1.0_f32 + 2.0_f32 * t) * ss, edge * (t * ss), tt * (3.0_f32 - 2.0_f32 * t), -(edge * (tt * s))]
}

/// The derivative of the basis in world units.
#[inline(always)]
fn basis_slope<T: Copy + Mul<Output = T> + Neg<Output = T> + Sub<f32, Output = T>>(t: T, inverse_edge: f32) -> [T; 4]
where
    f32: Sub<T, Output = T> + Mul<T, Output = T>,
{
    let s = 1.0_f32 - t;
    let down = inverse_edge * (-6.0_f32 * (t * s));
    [down, s * (1.0_f32 - 3.0_f32 * t), -down, t * (3.0_f32 * t - 2.0)]
}

/// The four pairs of corners along z, each made one.
#[inline(always)]
fn along_z(corners: &[&Numbers; 8], [a, b, c, d]: Weights) -> [Numbers; 4] {
    let (near, far) = (Vec4::new(a, b, a, b), Vec4::new(c, d, c, d));
    let pair = |i: usize| {
        let (low, high) = (corners[2 * i], corners[2 * i + 1]);
        [low[0] * near + high[0] * far, low[1] * near + high[1] * far]
    };
    [pair(0), pair(1), pair(2), pair(3)]
}

#[inline(always)]
fn along_y(v: &[Numbers; 4], [a, b, c, d]: Weights) -> [Numbers; 2] {
    let (near, far) = (Vec4::new(a, a, b, b), Vec4::new(c, c, d, d));
    let pair = |i: usize| [v[2 * i][0] * near + v[2 * i + 1][0] * far, v[2 * i][1] * near + v[2 * i + 1][1] * far];
    [pair(0), pair(1)]
}

#[inline(always)]
fn along_x(v: &[Numbers; 2], [a, b, c, d]: Weights) -> Vec4 {
    (v[0][0] * a + v[1][0] * c) + (v[0][1] * b + v[1][1] * d)
}

#[inline(always)]
fn value_at(corners: &[&Numbers; 8], t: [f32; 3], edge: f32) -> f32 {
    let [wx, wy, wz] = t.map(|t| basis(t, edge));
    let sum = along_x(&along_y(&along_z(corners, wz), wy), wx);
    (sum.x + sum.z) + (sum.y + sum.w)
}

/// F, ∂x, ∂y, ∂z.
#[inline(always)]
fn gradient_at(corners: &[&Numbers; 8], [x, y, z]: [f32; 3], edge: f32) -> [f32; 4] {
    let t = Vec4::new(x, y, z, 0.0);
    let (basis, slope) = (basis(t, edge), basis_slope(t, 1.0 / edge));
    let (wx, wy, wz) = (basis.map(|w| w.x), basis.map(|w| w.y), basis.map(|w| w.z));
    let (z0, z1) = (along_z(corners, wz), along_z(corners, slope.map(|w| w.z)));
    let y00 = along_y(&z0, wy);
    let sums = Mat4::from_cols(
        along_x(&y00, wx),
        along_x(&y00, slope.map(|w| w.x)),
        along_x(&along_y(&z0, slope.map(|w| w.y)), wx),
        along_x(&along_y(&z1, wy), wx),
    );
    // The four sums of four, side by side.
    let terms = sums.transpose();
    ((terms.x_axis + terms.z_axis) + (terms.y_axis + terms.w_axis)).to_array()
}

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
    /// The leaf's edge in world units.
    pub edge: [f32; BATCH],
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

/// Works out `at` and `cell`: `base + offset·inverse` along each axis, in a root of `size` smallest cells.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2", "x86_64+sse4.1"))]
pub fn place(points: &Points, base: [f64; 3], inverse: f64, size: i32, located: &mut Located) -> Extent {
    let mut extent = Extent { low: [i32::MAX; 3], high: [i32::MIN; 3], outside: false };
    let top = f64::from(size);
    let offsets = [&points.x, &points.y, &points.z];
    for axis in 0..3 {
        let at = &mut located.at[axis][..points.len];
        let cell = &mut located.cell[axis][..points.len];
        let (mut low, mut high, mut outside) = (i32::MAX, i32::MIN, 0);
        for ((at, cell), offset) in at.iter_mut().zip(cell).zip(offsets[axis]) {
            let wanted = base[axis] + f64::from(*offset) * inverse;
            let place = if wanted > 0.0 { wanted } else { 0.0 };
            let place = if place < top { place } else { top };
            outside |= i32::from(place != wanted);
            *at = place;
            *cell = (place as i32).min(size - 1);
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

#[inline(always)]
fn corners_of<'a>(leaves: &[[u32; 8]], numbers: &'a [Numbers], leaf: u32) -> [&'a Numbers; 8] {
    let [a, b, c, d, e, f, g, h] = leaves[leaf as usize];
    let of = |corner: u32| &numbers[corner as usize];
    // Written out: `map` is a call, for each point.
    [of(a), of(b), of(c), of(d), of(e), of(f), of(g), of(h)]
}

/// Values at points in any cells, as many as `out` holds.
#[multiversion(targets("x86_64+avx+avx2", "x86_64+sse4.1"))]
pub fn values(leaves: &[[u32; 8]], numbers: &[Numbers], located: &Located, out: &mut [f32]) {
    for (i, out) in out.iter_mut().enumerate().take(BATCH) {
        let corners = corners_of(leaves, numbers, located.leaf[i]);
        let t = [located.t[0][i], located.t[1][i], located.t[2][i]];
        *out = value_at(&corners, t, located.edge[i]);
    }
}

/// Values and gradients at points in any cells: F, ∂x, ∂y, ∂z at the first `len`.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2", "x86_64+sse4.1"))]
pub fn gradients(leaves: &[[u32; 8]], numbers: &[Numbers], located: &Located, out: [&mut [f32; BATCH]; 4], len: usize) {
    let [value, dx, dy, dz] = out;
    for i in 0..len.min(BATCH) {
        let corners = corners_of(leaves, numbers, located.leaf[i]);
        let t = [located.t[0][i], located.t[1][i], located.t[2][i]];
        [value[i], dx[i], dy[i], dz[i]] = gradient_at(&corners, t, located.edge[i]);
    }
}

// The same operations for one point after the other, in plain numbers, so that the compiler can put points side by
// side. `V4[corner along the axes not yet contracted][number]`.

type Plain = [f32; 8];

#[inline(always)]
fn plain_pair(low: &Plain, high: &Plain, w: Weights, bit: usize) -> Plain {
    let mut out = [0.0; 8];
    for d in 0..8 {
        let order = usize::from(d & bit != 0);
        out[d] = low[d] * w[order] + high[d] * w[2 + order];
    }
    out
}

#[inline(always)]
fn plain_z(c: &[Plain; 8], w: Weights) -> [Plain; 4] {
    [
        plain_pair(&c[0], &c[1], w, 1),
        plain_pair(&c[2], &c[3], w, 1),
        plain_pair(&c[4], &c[5], w, 1),
        plain_pair(&c[6], &c[7], w, 1),
    ]
}

#[inline(always)]
fn plain_y(v: &[Plain; 4], w: Weights) -> [Plain; 2] {
    [plain_pair(&v[0], &v[1], w, 2), plain_pair(&v[2], &v[3], w, 2)]
}

#[inline(always)]
fn plain_x(v: &[Plain; 2], w: Weights) -> f32 {
    let n = plain_pair(&v[0], &v[1], w, 4);
    let sum = [n[0] + n[4], n[1] + n[5], n[2] + n[6], n[3] + n[7]];
    (sum[0] + sum[2]) + (sum[1] + sum[3])
}

fn plain(corners: &[&Numbers; 8]) -> [Plain; 8] {
    corners.map(|[low, high]| {
        let ([a, b, c, d], [e, f, g, h]) = (low.to_array(), high.to_array());
        [a, b, c, d, e, f, g, h]
    })
}

/// Values at so many points that all lie in one cell; entries of `out` past them are unspecified.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2", "x86_64+sse4.1"))]
pub fn values_in_cell(corners: &[&Numbers; 8], t: &[[f32; BATCH]; 3], edge: f32, out: &mut [f32; BATCH], len: usize) {
    let c = plain(corners);
    let [x, y, z] = t;
    for i in 0..lanes(len) {
        let (wx, wy, wz) = (basis(x[i], edge), basis(y[i], edge), basis(z[i], edge));
        out[i] = plain_x(&plain_y(&plain_z(&c, wz), wy), wx);
    }
}

/// Values and gradients at so many points that all lie in one cell; entries of `out` past them are unspecified.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx+avx2", "x86_64+sse4.1"))]
pub fn gradients_in_cell(
    corners: &[&Numbers; 8],
    t: &[[f32; BATCH]; 3],
    edge: f32,
    out: [&mut [f32; BATCH]; 4],
    len: usize,
) {
    let inverse_edge = 1.0 / edge;
    let c = plain(corners);
    let [x, y, z] = t;
    let [value, dx, dy, dz] = out;
    let len = lanes(len);
    for i in 0..len {
        let (wx, wy, wz) = (basis(x[i], edge), basis(y[i], edge), basis(z[i], edge));
        let z0 = plain_z(&c, wz);
        let y00 = plain_y(&z0, wy);
        value[i] = plain_x(&y00, wx);
        dx[i] = plain_x(&y00, basis_slope(x[i], inverse_edge));
        dy[i] = plain_x(&plain_y(&z0, basis_slope(y[i], inverse_edge)), wx);
    }
    for i in 0..len {
        let z1 = plain_z(&c, basis_slope(z[i], inverse_edge));
        dz[i] = plain_x(&plain_y(&z1, basis(y[i], edge)), basis(x[i], edge));
    }
}
