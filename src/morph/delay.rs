//! Where a morph's shape waits: a share of its span, smooth in space.

use std::fmt;
use std::sync::Arc;

use glam::{DVec3, IVec3, Mat4, Vec4};
use multiversion::multiversion;
use rayon::prelude::*;

use super::coarse::CoarseGrid;
use super::error::Error;
use crate::attribute::Scalar;
use crate::field::{Aabb, BATCH, Gradients, Interval, Points};

/// The longest wait. Longer: all of the change falls into a frame or two.
pub(super) const LONGEST: f64 = 0.95;

/// How long each place waits, as a share of the morph's eased progress in \[0, 0.95\]: it starts then, and ends with all
/// others. In world space, standing still.
#[derive(Clone)]
pub struct Delay(pub Arc<Scalar>);

impl fmt::Debug for Delay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Delay")
    }
}

/// A delay by its values at the middles of the coarse grid's cells, as the control points of a quadratic B-spline: C¹,
/// never beyond the values around, and so with bounds over any box.
pub(super) struct DelayGrid {
    grid: CoarseGrid,
    /// By x, y and z, with a cell more at each end, which has its neighbour's; and one more at last, so that four can be
    /// read from any.
    values: Vec<f32>,
}

/// The values of a grid's cells as a [`DelayGrid`] keeps them.
fn beyond_faces(grid: &CoarseGrid, values: &[f32]) -> Vec<f32> {
    let last = grid.size() - 1;
    let along = |axis: usize| -1..=last[axis] + 1;
    let value = |cell: IVec3| values[grid.cell(cell.clamp(IVec3::ZERO, last))];
    along(0)
        .flat_map(|x| along(1).flat_map(move |y| along(2).map(move |z| IVec3::new(x, y, z))))
        .map(value)
        .chain([0.0])
        .collect()
}

impl DelayGrid {
    /// Fails where the delay is out of its range, or not a number.
    pub(super) fn new(grid: &CoarseGrid, delay: &Delay) -> Result<Self, Error> {
        let mut values = vec![0.0; grid.cell_count()];
        values.par_chunks_mut(BATCH).enumerate().for_each_init(
            || (delay.0.sampler(), [[0.0]; BATCH]),
            |(sampler, batch), (block, values)| {
                let (points, region) = grid.block_points(block);
                sampler.enter(&region);
                sampler.sample(&points, batch);
                sampler.leave();
                values.copy_from_slice(batch.as_flattened());
            },
        );
        match values.iter().find(|value| !(0.0..=LONGEST as f32).contains(*value)) {
            Some(value) => Err(Error::Setting { name: "delay", value: f64::from(*value), least: 0.0, most: LONGEST }),
            None => Ok(Self { grid: grid.clone(), values: beyond_faces(grid, &values) }),
        }
    }

    /// Where the value of a coarse cell stands, or of one a step beyond the grid.
    fn place(&self, cell: IVec3) -> usize {
        let ([x, y, z], size) = ((cell + 1).to_array().map(|at| at as usize), self.grid.size() + 2);
        (x * size.y as usize + y) * size.z as usize + z
    }

    /// The progress of the place that waits longest, when the morph's is `eased`.
    pub(super) fn last(&self, eased: f64) -> f64 {
        progress(eased, f64::from(self.values.iter().fold(0.0, |longest, delay| delay.max(longest))))
    }

    /// The progress at a place in the world, when the morph's is `eased`.
    pub(super) fn progress(&self, position: DVec3, eased: f64) -> f64 {
        progress(eased, self.delay(self.in_cells(position)))
    }

    /// The delay at a place in cells.
    fn delay(&self, place: DVec3) -> f64 {
        let nearest = (place + 0.5).floor();
        let weights = weights((place - nearest).to_array());
        let first = nearest.as_ivec3() - 1;
        let mut delay = 0.0;
        for (x, y) in (0..3).flat_map(|x| (0..3).map(move |y| (x, y))) {
            let row = self.place(first + IVec3::new(x, y, 0));
            let along: f64 = (0..3).map(|z| f64::from(self.values[row + z]) * weights[2][z]).sum();
            delay += along * weights[0][x as usize] * weights[1][y as usize];
        }
        delay
    }

    /// The delay at each place, and its gradient, in 1/world units.
    pub(super) fn delays(&self, points: &Points, out: &mut Gradients) {
        let size = self.grid.size();
        let row = size.z as u32 + 2;
        let lattice = Lattice {
            base: self.grid.in_cells(points.origin).to_array(),
            inverse: 1.0 / self.grid.edge(),
            last: (size - 1).as_dvec3().to_array(),
            strides: [(size.y as u32 + 2) * row, row],
        };
        spline(&self.values, &lattice, points, out);
    }

    /// The least and the most progress, when the morph's is `eased`, over each of some boxes of one size, from what is
    /// known of a box around them all.
    pub(super) fn bounds_around(
        &self,
        (middles, size): (&Points, DVec3),
        over: &Over,
        eased: f64,
        delays: &mut Gradients,
        out: &mut [[f32; BATCH]; 2],
    ) {
        self.delays(middles, delays);
        let (eased, change) = (eased as f32, over.change(size) as f32);
        let [least, most] = [over.values.lo as f32, over.values.hi as f32];
        let [lo, hi] = out;
        for i in 0..middles.len {
            lo[i] = progress_in_batch(eased, (delays.value[i] + change).min(most));
            hi[i] = progress_in_batch(eased, (delays.value[i] - change).max(least));
        }
    }

    /// The progress at each place when the morph's is `eased`, and its gradient, in 1/world units.
    pub(super) fn progresses(&self, points: &Points, eased: f64, out: &mut Gradients) {
        self.delays(points, out);
        progresses(eased as f32, points.len, out);
    }

    /// The time of colours at each place: from 0 on, past 1 where the morph's is.
    pub(super) fn colour_times(&self, points: &Points, time: f64, out: &mut Gradients) {
        self.delays(points, out);
        for delay in &mut out.value[..points.len] {
            *delay = from_0_on((time as f32 - *delay) / (1.0 - *delay));
        }
    }

    /// What is known of the delay over a box of the world.
    pub(super) fn over(&self, region: &Aabb) -> Over {
        let [least, most] = [region.min, region.max].map(|corner| self.in_cells(corner));
        let first = (least + 0.5).floor().as_ivec3() - 1;
        let last = (most + 0.5).floor().as_ivec3() + 1;
        let mut values = [f32::INFINITY, f32::NEG_INFINITY];
        let mut steps = [0.0_f32; 3];
        for x in first.x..=last.x {
            for y in first.y..=last.y {
                for z in first.z..=last.z {
                    let at = IVec3::new(x, y, z);
                    let value = self.values[self.place(at)];
                    values = [values[0].min(value), values[1].max(value)];
                    for (axis, step) in steps.iter_mut().enumerate() {
                        if at[axis] < last[axis] {
                            *step = step.max((self.values[self.place(at + IVec3::AXES[axis])] - value).abs());
                        }
                    }
                }
            }
        }
        let slopes = DVec3::from_array(steps.map(f64::from)) / self.grid.edge();
        let [lo, hi] = values.map(f64::from);
        let mut over = Over { values: Interval::new(lo - SLACK, hi + SLACK), slopes };
        let (middle, change) = (self.delay(self.in_cells(region.centre())), over.change(region.size()));
        over.values.lo = over.values.lo.max(middle - change);
        over.values.hi = over.values.hi.min(middle + change);
        over
    }

    /// A place in cells from the middle of the first one, held to the grid: beyond it the delay is that of its faces.
    fn in_cells(&self, position: DVec3) -> DVec3 {
        self.grid.in_cells(position).clamp(DVec3::ZERO, (self.grid.size() - 1).as_dvec3())
    }
}

/// The progress of a place that waits: 0 until `delay`, 1 at the end.
pub(super) fn progress(eased: f64, delay: f64) -> f64 {
    ((eased - delay) / (1.0 - delay)).clamp(0.0, 1.0)
}

/// What is known of a delay over a box.
pub(super) struct Over {
    values: Interval,
    /// The most that it changes along each axis, in 1/world units: by no more than its values do from a cell to the next.
    slopes: DVec3,
}

impl Over {
    /// Bounds of the progress when the morph's is `eased`.
    pub(super) fn progress(&self, eased: f64) -> Interval {
        Interval::new(progress(eased, self.values.hi), progress(eased, self.values.lo))
    }

    /// The most that the delay changes from the middle of a box of some size.
    fn change(&self, size: DVec3) -> f64 {
        self.slopes.dot(size) * 0.5 + SLACK
    }
}

/// What a delay in `f32` may be off, at most, twice.
const SLACK: f64 = 1e-6;

/// The three weights of a quadratic B-spline along each axis, so far from the middle one's place.
fn weights(from: [f64; 3]) -> [[f64; 3]; 3] {
    from.map(|from| {
        let (before, after) = (0.5 - from, 0.5 + from);
        [before * before * 0.5, 0.75 - from * from, after * after * 0.5]
    })
}

/// Where a batch lies among a [`DelayGrid`]'s values.
struct Lattice {
    /// The batch's origin, in cells.
    base: [f64; 3],
    /// Cells to a world unit.
    inverse: f64,
    /// The last cell along each axis.
    last: [f64; 3],
    /// Values from a cell to the next along x, and along y.
    strides: [u32; 2],
}

/// Points whose weights are worked out together.
const AT_A_TIME: usize = 16;

/// The weights of some points along one axis, and their rates in 1/world units.
type Weights = [[[f32; AT_A_TIME]; 3]; 2];

/// The B-spline and its gradient. Weights come first, of points side by side; then point by point, of each the 27 values in
/// nine rows.
#[multiversion(targets = "simd")]
fn spline(values: &[f32], lattice: &Lattice, points: &Points, out: &mut Gradients) {
    let len = points.len.min(BATCH);
    let [along_x, along_y] = lattice.strides.map(|stride| stride as usize);
    let mut by_axis: [Weights; 3] = [[[[0.0; AT_A_TIME]; 3]; 2]; 3];
    for first in (0..len).step_by(AT_A_TIME) {
        let mut rows = [0_u32; AT_A_TIME];
        for (axis, offsets) in [&points.x, &points.y, &points.z].into_iter().enumerate() {
            let offsets = &offsets[first..first + AT_A_TIME];
            let stride = [lattice.strides[0], lattice.strides[1], 1][axis];
            weights_in_batch(lattice, axis, offsets, &mut by_axis[axis], |n, nearest| rows[n] += nearest * stride);
        }
        for (n, row) in rows.into_iter().enumerate().take(len - first) {
            let [x, y, z] = &by_axis;
            let of = |weights: &[[f32; AT_A_TIME]; 3]| [weights[0][n], weights[1][n], weights[2][n]];
            let ([at_x, rate_x], [at_y, rate_y]) = ([of(&x[0]), of(&x[1])], [of(&y[0]), of(&y[1])]);
            let mut plane = [[Vec4::ZERO; 3]; 2];
            for (i, rows) in values[row as usize..].chunks(along_x).take(3).enumerate() {
                for j in 0..3 {
                    let row = Vec4::from_slice(&rows[j * along_y..]);
                    plane[0][j] += row * at_x[i];
                    plane[1][j] += row * rate_x[i];
                }
            }
            let sum = |plane: [Vec4; 3], by: [f32; 3]| plane[0] * by[0] + plane[1] * by[1] + plane[2] * by[2];
            let by_z = Mat4::from_cols(sum(plane[0], at_y), sum(plane[1], at_y), sum(plane[0], rate_y), Vec4::ZERO);
            let by_z = by_z.transpose();
            let by_z = [by_z.x_axis, by_z.y_axis, by_z.z_axis];
            let [value, dx, dy, _] = sum(by_z, of(&z[0])).to_array();
            let i = first + n;
            (out.value[i], out.dx[i], out.dy[i], out.dz[i]) = (value, dx, dy, sum(by_z, of(&z[1])).x);
        }
    }
}

/// Of points so far from a batch's origin along an axis: their weights; the cells that they are nearest to are told one by
/// one.
#[inline(always)]
fn weights_in_batch(
    lattice: &Lattice,
    axis: usize,
    offsets: &[f32],
    [weights, rates]: &mut Weights,
    mut nearest_cell: impl FnMut(usize, u32),
) {
    let (base, last, inverse) = (lattice.base[axis], lattice.last[axis], lattice.inverse as f32);
    for n in 0..AT_A_TIME {
        let place = base + f64::from(offsets[n]) * lattice.inverse;
        let place = if place > 0.0 { place } else { 0.0 };
        let place = if place < last { place } else { last };
        let nearest = (place + 0.5).floor();
        nearest_cell(n, (nearest + WHOLE).to_bits() as u32);
        let from = (place - nearest) as f32;
        let (before, after) = (0.5 - from, 0.5 + from);
        weights[0][n] = before * before * 0.5;
        weights[1][n] = 0.75 - from * from;
        weights[2][n] = after * after * 0.5;
        rates[0][n] = -before * inverse;
        rates[1][n] = -2.0 * from * inverse;
        rates[2][n] = after * inverse;
    }
}

/// 2⁵²: added to a whole number from 0 on, it leaves that number in the last bits.
const WHOLE: f64 = (1_u64 << 52) as f64;

#[multiversion(targets = "simd")]
fn progresses(eased: f32, len: usize, out: &mut Gradients) {
    for n in 0..len.min(BATCH) {
        let delay = out.value[n];
        let left = 1.0 / (1.0 - delay);
        let rate = if eased > delay { (eased - 1.0) * left * left } else { 0.0 };
        out.value[n] = progress_in_batch(eased, delay);
        out.dx[n] *= rate;
        out.dy[n] *= rate;
        out.dz[n] *= rate;
    }
}

/// [`progress`] in `f32`.
#[inline(always)]
fn progress_in_batch(eased: f32, delay: f32) -> f32 {
    let progress = from_0_on((eased - delay) / (1.0 - delay));
    if progress < 1.0 { progress } else { 1.0 }
}

#[inline(always)]
fn from_0_on(number: f32) -> f32 {
    if number > 0.0 { number } else { 0.0 }
}
