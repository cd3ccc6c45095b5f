//! One Newton step of many lanes at once, compiled for several vector widths. Plain arithmetic without branches; the
//! widths agree bit for bit.

use std::hint::select_unpredictable;

use multiversion::multiversion;

use crate::{
    field::{BATCH, Gradients, Points},
    grid::{BlockMask, mask},
};

use super::{
    lanes::Lanes,
    smooth::{GREATEST_SHARE, LAST_SLIDE, LAST_STEP, LAST_STRIDE},
};

/// Lanes in one pass: a few vector registers of any width.
const WIDTH: usize = 16;

/// The greatest square of the share of a residual that one step left, for its bend to be told from it.
const MOST_LEFT: f32 = 0.04;

type Wide = [f32; WIDTH];

/// What became of a lane's trial point. Bytes, which vector loops can write.
pub(super) mod verdict {
    /// Taken as the new base; the next trial is set.
    pub const MOVES: u8 = 0;
    /// Worse than the base: nothing was changed.
    pub const FAILS: u8 = 1;
    /// So near that `landing` is the foot, at `height`.
    pub const LANDS: u8 = 2;
    /// Its foot is out of reach, or outside of the region, which holds all feet within reach.
    pub const IS_BEYOND: u8 = 3;
    /// From here on the lane is done.
    pub const DONE: u8 = LANDS;
}

#[inline(always)]
fn load(from: &[f32; BATCH], first: usize) -> Wide {
    *from[first..].first_chunk().expect("passes divide the batch")
}

// Spelt out: a `map` is not inlined here.
#[inline(always)]
fn load_each([x, y, z]: [&[f32; BATCH]; 3], first: usize) -> [Wide; 3] {
    [load(x, first), load(y, first), load(z, first)]
}

#[inline(always)]
fn load_axes([x, y, z]: &[[f32; BATCH]; 3], first: usize) -> [Wide; 3] {
    [load(x, first), load(y, first), load(z, first)]
}

/// The lanes of the whole passes that hold the first `len`.
fn whole_passes(len: usize) -> usize {
    len.next_multiple_of(WIDTH)
}

#[inline(always)]
fn store(wide: Wide, to: &mut [f32; BATCH], first: usize) {
    to[first..first + WIDTH].copy_from_slice(&wide);
}

/// Of the first `len` queries those that |F|/|∇F| puts no farther than `far`; where F has no gradient nothing is known,
/// and they count. Bits past `len` are unspecified.
#[multiversion(targets = "simd")]
pub(super) fn near(at: &Gradients, len: usize, far: f32) -> BlockMask {
    let mut near = [0; BATCH];
    for i in 0..whole_passes(len) {
        let square = at.dx[i] * at.dx[i] + at.dy[i] * at.dy[i] + at.dz[i] * at.dz[i];
        let is_far = at.value[i] * at.value[i] > far * far * square;
        near[i] = u8::from(!is_far);
    }
    mask::pack(&near)
}

/// Where the first `len` of `distances` are less than `others`, and than `most`. Bits past `len` are unspecified.
#[multiversion(targets = "simd")]
pub(super) fn nearer(distances: &[f32; BATCH], others: &[f32; BATCH], most: f32, len: usize) -> BlockMask {
    let mut nearer = [0; BATCH];
    for i in 0..whole_passes(len) {
        nearer[i] = u8::from((distances[i] < others[i]) & (distances[i] < most));
    }
    mask::pack(&nearer)
}

/// Where at least two of the lists of distances are less than the limits, of the first `len`.
pub(super) fn several<'a>(
    lists: impl Iterator<Item = &'a [f32; BATCH]>,
    limits: &[f32; BATCH],
    len: usize,
) -> BlockMask {
    let (mut one, mut two) = ([0; 8], [0; 8]);
    for distances in lists {
        let less = nearer(distances, limits, f32::INFINITY, len);
        for x in 0..8 {
            two[x] |= one[x] & less[x];
            one[x] |= less[x];
        }
    }
    two
}

/// The steps of `length` along the ways to the lanes' points from their queries p; none where there is no way.
#[multiversion(targets = "simd")]
pub(super) fn steps_onward(lanes: &mut Lanes, length: f32) {
    let Lanes { points, p: [px, py, pz], normal_step: [sx, sy, sz], .. } = lanes;
    for i in 0..whole_passes(points.len) {
        let (x, y, z) = (points.x[i] - px[i], points.y[i] - py[i], points.z[i] - pz[i]);
        let square = x * x + y * y + z * z;
        let scale = if square > 0.0 { length / square.sqrt() } else { 0.0 };
        (sx[i], sy[i], sz[i]) = (x * scale, y * scale, z * scale);
    }
}

/// The lanes' points moved by so many of their steps, within the bounds.
#[multiversion(targets = "simd")]
pub(super) fn stepped(lanes: &Lanes, count: f32, out: &mut Points) {
    let [least, greatest] = lanes.bounds;
    let (from, steps) = ([&lanes.points.x, &lanes.points.y, &lanes.points.z], &lanes.normal_step);
    for (axis, out) in [&mut out.x, &mut out.y, &mut out.z].into_iter().enumerate() {
        for i in 0..whole_passes(lanes.points.len) {
            out[i] = (from[axis][i] + count * steps[axis][i]).max(least[axis]).min(greatest[axis]);
        }
    }
}

/// Bases all lanes at their queries p, where `gradients` holds F, and sets their trial points across the surface.
#[multiversion(targets = "simd")]
pub(super) fn begin(lanes: &mut Lanes, gradients: &Gradients) {
    let [least, greatest] = lanes.bounds;
    let slope = [&gradients.dx, &gradients.dy, &gradients.dz];
    for first in (0..lanes.points.len).step_by(WIDTH) {
        let trial = [&mut lanes.points.x, &mut lanes.points.y, &mut lanes.points.z];
        let mut square = [0.0; WIDTH];
        for slope in slope {
            for l in 0..WIDTH {
                square[l] += slope[first + l] * slope[first + l];
            }
        }
        for l in 0..WIDTH {
            let residual = gradients.value[first + l].abs() * (1.0 / square[l].sqrt());
            lanes.residual[first + l] = residual;
            lanes.merit[first + l] = 1.3 * residual;
            lanes.along[first + l] = 1.0;
            lanes.across[first + l] = 1.0;
        }
        for (axis, trial) in trial.into_iter().enumerate() {
            for l in 0..WIDTH {
                let i = first + l;
                let step = -slope[axis][i] * (gradients.value[i] / square[l]);
                let p = lanes.p[axis][i];
                lanes.base[axis][i] = p;
                lanes.normal_step[axis][i] = step;
                lanes.tangent_step[axis][i] = 0.0;
                trial[i] = (p + step).max(least[axis]).min(greatest[axis]);
            }
        }
    }
}

/// Judges all lanes' trial points by what was evaluated there, and sets the next ones.
///
/// With n the unit gradient and e = F/|∇F| at q, the zero set is near q the plane that p + s·n meets at
/// s = −(e + (p − q)·n): a full step goes there.
#[multiversion(targets = "simd")]
pub(super) fn judge(lanes: &mut Lanes, gradients: &Gradients, unit: f32, reach: f32) {
    judge_trials::<false>(lanes, gradients, unit, reach);
}

/// The same right after [`begin`]: no lane has stepped along the surface yet. The height of lanes that do not land is
/// infinite.
#[multiversion(targets = "simd")]
pub(super) fn judge_first(lanes: &mut Lanes, gradients: &Gradients, unit: f32, reach: f32) {
    judge_trials::<true>(lanes, gradients, unit, reach);
}

#[inline(always)]
fn judge_trials<const FIRST: bool>(lanes: &mut Lanes, gradients: &Gradients, unit: f32, reach: f32) {
    let (near, slide) = (LAST_STEP * unit, LAST_SLIDE * unit);
    let [least, greatest] = lanes.bounds;
    for first in (0..lanes.points.len).step_by(WIDTH) {
        let p = load_axes(&lanes.p, first);
        let q = load_each([&lanes.points.x, &lanes.points.y, &lanes.points.z], first);
        let value = load(&gradients.value, first);
        let slope = load_each([&gradients.dx, &gradients.dy, &gradients.dz], first);
        let base = load_axes(&lanes.base, first);
        let normal_step = load_axes(&lanes.normal_step, first);
        let tangent_step = if FIRST { [[0.0; WIDTH]; 3] } else { load_axes(&lanes.tangent_step, first) };
        let merit = load(&lanes.merit, first);
        let residual = load(&lanes.residual, first);
        let (along, across) =
            if FIRST { ([1.0; WIDTH], [1.0; WIDTH]) } else { (load(&lanes.along, first), load(&lanes.across, first)) };
        // What comes out is kept apart from what went in, and chosen without branches: else they become masked stores
        // (see `lane_math`).
        let [mut new_q, mut new_base, mut new_normal_step, mut new_tangent_step] = [[[0.0; WIDTH]; 3]; 4];
        let [mut new_merit, mut new_residual, mut new_along, mut new_across] = [[0.0; WIDTH]; 4];
        let mut landing = [[0.0; WIDTH]; 3];
        let mut height = [0.0; WIDTH];
        let mut verdicts = [0; WIDTH];
        for l in 0..WIDTH {
            let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            let at = |a: &[Wide; 3]| [a[0][l], a[1][l], a[2][l]];
            let inverse = 1.0 / dot(at(&slope), at(&slope)).sqrt();
            let n = at(&slope).map(|c| c * inverse);
            let e = value[l] * inverse;
            let towards = [0, 1, 2].map(|axis| p[axis][l] - q[axis][l]);
            let up = dot(towards, n);
            let tangent = [0, 1, 2].map(|axis| towards[axis] - n[axis] * up);
            // The distance to where the next step across the surface lands, and some doubt about landing there.
            let ahead = [0, 1, 2].map(|axis| towards[axis] + n[axis] * e);
            let trial_merit = dot(ahead, ahead).sqrt() + 0.3 * e.abs();

            // A step that left the surface far (the more so the longer it was) has a merit not to be trusted.
            let before = at(&tangent_step);
            let length = if FIRST { 0.0 } else { along[l] * dot(before, before).sqrt() };
            let strayed = e.abs() > 0.8 * residual[l] + 0.3 * length;
            let improves = (trial_merit <= merit[l] * 1.0001) & !strayed;
            let approaches = (residual[l] > near) & (e.abs() < 0.8 * residual[l]);
            let taken = (trial_merit < f32::INFINITY) & (improves | approaches);

            // What a full step across the surface left of the residual tells how F bends along it, and so what the
            // next step will leave: e³ to the residual's square, which that step takes along.
            let straight = (merit[l] < f32::INFINITY) & (across[l] == 1.0) & (length <= slide);
            let share_left = e * e / (residual[l] * residual[l]);
            let bends_little = straight & (share_left <= MOST_LEFT);
            let bend = select_unpredictable(bends_little, share_left, 0.0);
            let last_stride = bends_little & (e.abs() * share_left <= LAST_STRIDE * unit);
            let at_last = (e.abs() <= near) | last_stride;
            let lands = taken & at_last & (dot(tangent, tangent) <= slide * slide);
            let e_ahead = e + e * bend;

            // The share of the tangential step that would have brought it to zero, were its change linear in the
            // step (the secant of Barzilai and Borwein); the greatest where the steps grow, as on the far side of
            // a ball.
            let change = [0, 1, 2].map(|axis| before[axis] - tangent[axis]);
            let (gain, size) = (dot(before, change), dot(change, change));
            #[allow(clippy::manual_clamp, reason = "0 / 0 becomes 0.1 so; a clamp would keep it")]
            let secant = (along[l] * gain / size).max(0.1).min(GREATEST_SHARE);
            let share = select_unpredictable(gain <= 0.0, GREATEST_SHARE, secant);
            let first_of_all = (merit[l] == f32::INFINITY) | (dot(before, before) == 0.0) | (size == 0.0);
            let share = select_unpredictable(FIRST | first_of_all, 1.0, share);

            // Already at a face of the region, and on its way out through it.
            let mut leaves = false;
            for axis in 0..3 {
                let trial = q[axis][l] - n[axis] * e + tangent[axis] * share;
                let beyond_least =
                    (trial < least[axis]) & (q[axis][l] == least[axis]) & (p[axis][l] - least[axis] >= reach);
                let beyond_greatest =
                    (trial > greatest[axis]) & (q[axis][l] == greatest[axis]) & (greatest[axis] - p[axis][l] >= reach);
                leaves |= beyond_least | beyond_greatest;
                let trial = trial.max(least[axis]).min(greatest[axis]);
                new_base[axis][l] = select_unpredictable(taken, q[axis][l], base[axis][l]);
                new_q[axis][l] = select_unpredictable(taken, trial, q[axis][l]);
                new_normal_step[axis][l] = select_unpredictable(taken, -n[axis] * e, normal_step[axis][l]);
                new_tangent_step[axis][l] = select_unpredictable(taken, tangent[axis], tangent_step[axis][l]);
                landing[axis][l] = p[axis][l] - n[axis] * (e_ahead + up);
            }
            new_merit[l] = select_unpredictable(taken, trial_merit, merit[l]);
            new_residual[l] = select_unpredictable(taken, e.abs(), residual[l]);
            new_along[l] = select_unpredictable(taken, share, along[l]);
            new_across[l] = select_unpredictable(taken, 1.0, across[l]);
            let landing_height = (e_ahead + up).abs();
            let not_landed = select_unpredictable(taken, verdict::MOVES, verdict::FAILS);
            let judged = select_unpredictable(lands, verdict::LANDS, not_landed);
            if FIRST {
                // The foot is where F leads from q, but for what was left across and along the surface, twice over.
                let doubt = 2.0 * (e.abs() + tangent[0].abs() + tangent[1].abs() + tangent[2].abs());
                let farthest = reach + doubt;
                leaves |= dot(towards, towards) > farthest * farthest;
            }
            height[l] = select_unpredictable(lands | !FIRST, landing_height, f32::INFINITY);
            verdicts[l] = select_unpredictable(taken & !lands & leaves, verdict::IS_BEYOND, judged);
        }
        for axis in 0..3 {
            store(new_base[axis], &mut lanes.base[axis], first);
            store(new_normal_step[axis], &mut lanes.normal_step[axis], first);
            store(new_tangent_step[axis], &mut lanes.tangent_step[axis], first);
            store(landing[axis], &mut lanes.landing[axis], first);
        }
        store(new_q[0], &mut lanes.points.x, first);
        store(new_q[1], &mut lanes.points.y, first);
        store(new_q[2], &mut lanes.points.z, first);
        store(new_merit, &mut lanes.merit, first);
        store(new_residual, &mut lanes.residual, first);
        store(new_along, &mut lanes.along, first);
        store(new_across, &mut lanes.across, first);
        store(height, &mut lanes.height, first);
        lanes.verdict[first..first + WIDTH].copy_from_slice(&verdicts);
    }
}
