//! One cell's tricubic Hermite patch in `f64`: its derivatives at a point, its Bernstein coefficients, and the
//! bounds they give.
//!
//! A corner carries eight numbers, its *jet*: index bit 4 stands for ∂x, bit 2 for ∂y, bit 1 for ∂z, so they are
//! F, Fz, Fy, Fyz, Fx, Fxz, Fxy, Fxyz. Corners are ordered the same way: bit 4 the greater x, 2 the greater y,
//! 1 the greater z.

use crate::field::Interval;

/// The eight numbers of a corner.
pub type Jet = [f64; 8];

/// The bits of a jet's or a corner's index that stand for x, y and z.
pub const AXIS_BIT: [usize; 3] = [4, 2, 1];

/// A 4×4×4 array, x slowest.
pub type Tensor = [f64; 64];

/// The jets of a cell's eight corners and its edge, in world units.
#[derive(Clone, Copy)]
pub struct Patch {
    /// Jets by corner.
    pub corners: [Jet; 8],
    /// The cell's edge.
    pub edge: f64,
}

/// `[derivative order][corner][value or slope]`: the cubic Hermite basis on \[0, 1\] and its slope, for slopes in
/// world units over an edge.
fn hermite(t: f64, edge: f64) -> [[[f64; 2]; 2]; 2] {
    let s = 1.0 - t;
    let down = 6.0 * t * (t - 1.0) / edge;
    [
        [[(1.0 + 2.0 * t) * s * s, edge * t * s * s], [t * t * (3.0 - 2.0 * t), edge * t * t * (t - 1.0)]],
        [[down, s * (1.0 - 3.0 * t)], [-down, t * (3.0 * t - 2.0)]],
    ]
}

/// The jet between two corners along one axis, by the [`hermite`] weights there.
#[inline(always)]
fn contracted(low: &Jet, high: &Jet, bit: usize, weight: &[[[f64; 2]; 2]; 2]) -> Jet {
    let mut out = [0.0; 8];
    for (slot, out) in out.iter_mut().enumerate() {
        let [[a, b], [c, d]] = weight[usize::from(slot & bit != 0)];
        *out = low[slot & !bit] * a + low[slot | bit] * b + high[slot & !bit] * c + high[slot | bit] * d;
    }
    out
}

impl Patch {
    /// The jet at a point given in the cell's own \[0, 1\]³.
    pub fn jet(&self, t: [f64; 3]) -> Jet {
        // One axis after the other: the two corners along the axis are contracted to the wanted order.
        match t.iter().position(|t| *t == 0.0 || *t == 1.0) {
            Some(0) => self.jet_on_face::<4, 2, 1>(t[0], [t[1], t[2]]),
            Some(1) => self.jet_on_face::<2, 4, 1>(t[1], [t[0], t[2]]),
            Some(_) => self.jet_on_face::<1, 4, 2>(t[2], [t[0], t[1]]),
            None => {
                let weight = t.map(|t| hermite(t, self.edge));
                let c = &self.corners;
                let x: [Jet; 4] = std::array::from_fn(|i| contracted(&c[i], &c[i | 4], AXIS_BIT[0], &weight[0]));
                let [near, far] = [0, 1].map(|i| contracted(&x[i], &x[i | 2], AXIS_BIT[1], &weight[1]));
                contracted(&near, &far, AXIS_BIT[2], &weight[2])
            }
        }
    }

    /// The same at 0 or 1 along one axis, where four corners count.
    fn jet_on_face<const AXIS: usize, const FIRST: usize, const SECOND: usize>(&self, at: f64, t: [f64; 2]) -> Jet {
        let [first, second] = t.map(|t| hermite(t, self.edge));
        let corner = |bits: usize| &self.corners[if at == 0.0 { bits } else { AXIS | bits }];
        let near = contracted(corner(0), corner(FIRST), FIRST, &first);
        let far = contracted(corner(SECOND), corner(FIRST | SECOND), FIRST, &first);
        contracted(&near, &far, SECOND, &second)
    }

    /// The patch that is linear along each axis between the same values at the corners.
    pub fn linear(&self) -> Self {
        // Of such a one a derivative along an axis is a difference along an edge.
        fn derivative(patch: &Patch, corner: usize, slot: usize) -> f64 {
            let bit = slot & slot.wrapping_neg();
            if bit == 0 {
                return patch.corners[corner][0];
            }
            let at = |corner: usize| derivative(patch, corner, slot & !bit);
            (at(corner | bit) - at(corner & !bit)) / patch.edge
        }
        let jet = |corner: usize| std::array::from_fn(|slot| derivative(self, corner, slot));
        Self { corners: std::array::from_fn(jet), edge: self.edge }
    }

    /// The Bernstein coefficients of the whole cell.
    pub fn bernstein(&self) -> Tensor {
        let third = self.edge / 3.0;
        self.changed(|[near, rise, far, fall]| [near, near + third * rise, far - third * fall, far])
    }

    /// The coefficients of the powers of places in the cell's own \[0, 1\]³.
    pub fn powers(&self) -> Tensor {
        self.changed(|[near, rise, far, fall]| {
            let (rise, fall, step) = (self.edge * rise, self.edge * fall, far - near);
            [near, rise, 3.0 * step - 2.0 * rise - fall, rise + fall - 2.0 * step]
        })
    }

    /// The jets with each line along an axis changed, of value and slope at the near corner, then at the far one.
    #[inline(always)]
    fn changed(&self, change: impl Fn([f64; 4]) -> [f64; 4] + Copy) -> Tensor {
        let mut out = [0.0; 64];
        for (corner, jet) in self.corners.iter().enumerate() {
            for (slot, number) in jet.iter().enumerate() {
                let place = |bit: usize| 2 * usize::from(corner & bit != 0) + usize::from(slot & bit != 0);
                out[place(4) * 16 + place(2) * 4 + place(1)] = *number;
            }
        }
        for axis in 0..3 {
            change_lines(&mut out, axis, change);
        }
        out
    }
}

/// Replaces each line of four numbers along an axis.
#[inline(always)]
fn change_lines(tensor: &mut Tensor, axis: usize, change: impl Fn([f64; 4]) -> [f64; 4]) {
    match axis {
        0 => change_lines_apart::<16>(tensor, change),
        1 => change_lines_apart::<4>(tensor, change),
        _ => change_lines_apart::<1>(tensor, change),
    }
}

/// The same for numbers so far apart, which a vector loop has to know.
#[inline(always)]
fn change_lines_apart<const STRIDE: usize>(tensor: &mut Tensor, change: impl Fn([f64; 4]) -> [f64; 4]) {
    for lines in tensor.chunks_exact_mut(4 * STRIDE) {
        for start in 0..STRIDE {
            let changed = change(std::array::from_fn(|i| lines[start + i * STRIDE]));
            for (i, number) in changed.into_iter().enumerate() {
                lines[start + i * STRIDE] = number;
            }
        }
    }
}

/// The coefficients of a sub-interval of a cubic, by blossoming.
pub fn cut(c: [f64; 4], lo: f64, hi: f64) -> [f64; 4] {
    let mix = |a: f64, b: f64, t: f64| a * (1.0 - t) + b * t;
    let blossom = |r: f64, s: f64, t: f64| {
        let first = [mix(c[0], c[1], r), mix(c[1], c[2], r), mix(c[2], c[3], r)];
        let second = [mix(first[0], first[1], s), mix(first[1], first[2], s)];
        mix(second[0], second[1], t)
    };
    [blossom(lo, lo, lo), blossom(lo, lo, hi), blossom(lo, hi, hi), blossom(hi, hi, hi)]
}

/// The Bernstein coefficients over a part of the cell, given in the cell's own \[0, 1\]³.
pub fn restrict(tensor: &Tensor, lo: [f64; 3], hi: [f64; 3]) -> Tensor {
    let mut out = *tensor;
    for axis in 0..3 {
        if lo[axis] <= 0.0 && hi[axis] >= 1.0 {
            continue;
        }
        change_lines(&mut out, axis, |c| cut(c, lo[axis], hi[axis]));
    }
    out
}

/// The coefficients of ∂F along an axis, raised to degree 3 along it.
fn slope(tensor: &Tensor, axis: usize, edge: f64) -> Tensor {
    let mut out = *tensor;
    change_lines(&mut out, axis, |c| {
        let d: [f64; 3] = std::array::from_fn(|i| 3.0 * (c[i + 1] - c[i]) / edge);
        [d[0], (d[0] + 2.0 * d[1]) / 3.0, (2.0 * d[1] + d[2]) / 3.0, d[2]]
    });
    out
}

/// The coefficients of ∂F along each axis, over a box of the given edges.
pub fn slopes(tensor: &Tensor, edges: [f64; 3]) -> [Tensor; 3] {
    std::array::from_fn(|axis| slope(tensor, axis, edges[axis]))
}

/// Bounds over a cell or a part of it.
#[derive(Clone, Copy, Debug)]
pub struct PatchBounds {
    /// Of F.
    pub value: Interval,
    /// Of ∂F/∂x, ∂F/∂y, ∂F/∂z.
    pub gradient: [Interval; 3],
}

fn range(tensor: &Tensor) -> Interval {
    Interval::new(extreme(tensor, lesser), extreme(tensor, greater))
}

// One vector instruction each, unlike those of `f64`, which make good for what is no number.

#[inline(always)]
fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The greater of two numbers.
#[inline(always)]
pub fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The least or greatest number, found in lanes: one number for all would be waited for at each step.
#[inline(always)]
fn extreme(tensor: &Tensor, choose: impl Fn(f64, f64) -> f64) -> f64 {
    let [first, rest @ ..] = tensor.as_chunks::<8>().0 else { unreachable!("a tensor has 64 numbers") };
    let mut lanes = *first;
    for row in rest {
        for (lane, number) in lanes.iter_mut().zip(row) {
            *lane = choose(*lane, *number);
        }
    }
    lanes[1..].iter().fold(lanes[0], |chosen, lane| choose(chosen, *lane))
}

/// Grows an interval by what the `f32` evaluation of a value or slope of that size may be off.
pub fn padded(interval: Interval, size: f64) -> Interval {
    // Sums of 64 terms in f32: a few units in the last place of the largest.
    let pad = 2e-6 * size;
    Interval::new(interval.lo - pad, interval.hi + pad)
}

/// Bounds of F and its gradient from Bernstein coefficients over a box and those of its [`slopes`]: a polynomial stays in
/// the hull of its coefficients. `cell` is the edge of the whole cell.
pub fn bounds(tensor: &Tensor, slopes: &[Tensor; 3], cell: f64) -> PatchBounds {
    let value = range(tensor);
    let size = magnitude(value);
    let gradient = std::array::from_fn(|axis| padded(range(&slopes[axis]), slope_size(size, cell)));
    PatchBounds { value: padded(value, size), gradient }
}

/// What the rounding of slopes is relative to, at most: as differences of values over the cell's edge they would carry the
/// values' rounding, of which the powers' coefficients, made in `f64`, carry less.
fn slope_size(value: f64, cell: f64) -> f64 {
    1.0 + value / cell
}

/// What bounds of |∇F| over a cell of some edge are to be greater by.
pub fn rounding_of_slopes(tensor: &Tensor, cell: f64) -> f64 {
    4e-6 * slope_size(largest(tensor), cell)
}

/// The greatest of the numbers without their signs.
fn largest(tensor: &Tensor) -> f64 {
    magnitude(range(tensor))
}

fn magnitude(range: Interval) -> f64 {
    range.lo.abs().max(range.hi.abs())
}

/// The greatest mixed second derivative of a cell, and the third.
pub fn mixed(tensor: &Tensor, edge: f64) -> (f64, f64) {
    let (x, y) = (slope(tensor, 0, edge), slope(tensor, 1, edge));
    let xy = slope(&x, 1, edge);
    let second = largest(&xy).max(largest(&slope(&x, 2, edge))).max(largest(&slope(&y, 2, edge)));
    (second, largest(&slope(&xy, 2, edge)))
}

/// Σ c_ijk xⁱ yʲ zᵏ with all derivatives of a jet.
#[cfg(test)]
pub fn polynomial(p: [f64; 3]) -> Jet {
    let mut jet = [0.0; 8];
    for i in 0..64 {
        let coefficient = f64::from(i * 37 % 19 - 9) / 9.0;
        let powers = [i >> 4, (i >> 2) & 3, i & 3];
        for (slot, number) in jet.iter_mut().enumerate() {
            let mut term = coefficient;
            for axis in 0..3 {
                let n: i32 = powers[axis];
                term *= if slot & AXIS_BIT[axis] == 0 {
                    p[axis].powi(n)
                } else if n == 0 {
                    0.0
                } else {
                    f64::from(n) * p[axis].powi(n - 1)
                };
            }
            *number += term;
        }
    }
    jet
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tricubic_polynomials_are_kept() {
        let (origin, edge) = ([-0.3, 0.2, 0.5], 0.7);
        let at = |t: [f64; 3]| polynomial(std::array::from_fn(|axis| origin[axis] + t[axis] * edge));
        let corner = |corner: usize| at(std::array::from_fn(|axis| f64::from(corner as u32 >> (2 - axis) & 1)));
        let patch = Patch { corners: std::array::from_fn(corner), edge };
        let (tensor, powers) = (patch.bernstein(), patch.powers());
        for t in [[0.1, 0.2, 0.9], [0.5, 0.5, 0.5], [1.0, 0.0, 0.3]] {
            let (got, want) = (patch.jet(t), at(t));
            for slot in 0..8 {
                assert!((got[slot] - want[slot]).abs() < 1e-11 * (1.0 + want[slot].abs()), "{slot}: {got:?} {want:?}");
            }
            let term = |i: usize| {
                powers[i] * t[0].powi(i as i32 >> 4) * t[1].powi(i as i32 >> 2 & 3) * t[2].powi(i as i32 & 3)
            };
            let sum: f64 = (0..64).map(term).sum();
            assert!((sum - want[0]).abs() < 1e-11 * (1.0 + want[0].abs()), "{sum} for {}", want[0]);
            // A coefficient at a corner of a part is the value there.
            let part = restrict(&tensor, t.map(|t| t * 0.5), t.map(|t| 0.5 + t * 0.5));
            let want = at(t.map(|t| t * 0.5))[0];
            assert!((part[0] - want).abs() < 1e-11 * (1.0 + want.abs()));
        }
    }
}
