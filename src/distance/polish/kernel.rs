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
    /// Its foot is outside of the region, which holds all feet within reach.
    pub const IS_BEYOND: u8 = 3;
}

#[inline(always)]
pub(super) fn load<const N: usize>(from: &[f32; BATCH], first: usize) -> [f32; N] {
    *from[first..].first_chunk().expect("passes divide the batch")
}

// Spelt out: a `map` is not inlined here.
#[inline(always)]
pub(super) fn load_each<const N: usize>([x, y, z]: [&[f32; BATCH]; 3], first: usize) -> [[f32; N]; 3] {
    [load(x, first), load(y, first), load(z, first)]
}

#[inline(always)]
fn load_axes([x, y, z]: &[[f32; BATCH]; 3], first: usize) -> [Wide; 3] {
    [load(x, first), load(y, first), load(z, first)]
}

/// The lanes of the whole passes that hold the first `len`. Inlined, so that loops know the bound.
#[inline(always)]
pub(super) fn whole_passes(len: usize) -> usize {
    len.next_multiple_of(WIDTH).min(BATCH)
}

#[inline(always)]
pub(super) fn store<const N: usize>(lanes: [f32; N], to: &mut [f32; BATCH], first: usize) {
    to[first..first + N].copy_from_slice(&lanes);
}

/// Of the first `len` queries those that |F|/|∇F| puts no farther than `far`; where F has no gradient nothing is known,
/// and they count. Bits past `len` are unspecified.
#[multiversion(targets = "simd")]
pub(super) fn near(at: &Gradients, len: usize, far: f32) -> BlockMask {
    let mut near = [0; BATCH];
    for i in 0..whole_passes(len) {
        near[i] = u8::from(!is_farther(at.value[i], slope_squared(at, i), far));
    }
    mask::pack_first(&near, len)
}

/// The same of the voxels of a block, less those that |F| and the steepest |∇F| of them all put farther than
/// `farthest`.
#[multiversion(targets = "simd")]
pub(super) fn near_in_block(at: &Gradients, far: f32, farthest: f32) -> BlockMask {
    // Lane by lane: one number for all would be waited for at each step.
    let mut steepest: Wide = [0.0; WIDTH];
    let mut squares = [0.0; BATCH];
    for first in (0..BATCH).step_by(WIDTH) {
        let [dx, dy, dz]: [Wide; 3] = load_each([&at.dx, &at.dy, &at.dz], first);
        let mut square: Wide = [0.0; WIDTH];
        for l in 0..WIDTH {
            square[l] = dot([dx[l], dy[l], dz[l]], [dx[l], dy[l], dz[l]]);
            steepest[l] = steepest[l].max(square[l]);
        }
        store(square, &mut squares, first);
    }
    let steepest = steepest.into_iter().fold(0.0, f32::max);
    let mut near = [0; BATCH];
    for i in 0..BATCH {
        let value = at.value[i];
        let is_far = is_farther(value, squares[i], far) | is_farther(value, steepest, farthest);
        near[i] = u8::from(!is_far);
    }
    mask::pack(&near)
}

/// Whether |F| by the square of |∇F| puts the surface farther than `far`.
#[inline(always)]
fn is_farther(value: f32, slope_squared: f32, far: f32) -> bool {
    value * value > far * far * slope_squared
}

#[inline(always)]
fn slope_squared(at: &Gradients, i: usize) -> f32 {
    let slope = [at.dx[i], at.dy[i], at.dz[i]];
    dot(slope, slope)
}

/// Where the first `len` of `distances` are less than `others`, and than `most`. Bits past `len` are unspecified.
#[multiversion(targets = "simd")]
pub(super) fn nearer(distances: &[f32; BATCH], others: &[f32; BATCH], most: f32, len: usize) -> BlockMask {
    let mut nearer = [0; BATCH];
    for i in 0..whole_passes(len) {
        nearer[i] = u8::from((distances[i] < others[i]) & (distances[i] < most));
    }
    mask::pack_first(&nearer, len)
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
            out[i] = within(from[axis][i] + count * steps[axis][i], least[axis], greatest[axis]);
        }
    }
}

/// What a trial point q of a query p tells.
///
/// With n the unit gradient and e = F/|∇F| at q, the zero set is near q the plane that p + s·n meets at
/// s = −(e + (p − q)·n): a full step goes there.
pub(super) struct Trial {
    /// The unit gradient n.
    pub normal: [f32; 3],
    /// e.
    pub residual: f32,
    /// p − q, and its part along the surface.
    pub towards: [f32; 3],
    /// See `towards`.
    pub tangent: [f32; 3],
    /// The distance to where the next step across the surface lands, and some doubt about landing there.
    pub merit: f32,
    /// Whether it is better than what was there before.
    pub taken: bool,
    /// Whether the foot is told from here: the step from p to it along n.
    pub lands: bool,
    /// See `lands`.
    pub landing: f32,
}

/// What was before a trial.
pub(super) struct Before {
    pub merit: f32,
    pub residual: f32,
    /// How far the step went along the surface.
    pub length: f32,
    /// Whether it went all the way across.
    pub full: bool,
}

/// A number brought between two others; what is none becomes the lesser. An instruction for each side, unlike `f32`'s own.
#[inline(always)]
pub fn within(number: f32, least: f32, greatest: f32) -> f32 {
    let number = if number > least { number } else { least };
    if number < greatest { number } else { greatest }
}

#[inline(always)]
pub(super) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Looks at what was evaluated at q: F and its gradient. `unit` as in [`super::Request`].
#[inline(always)]
pub(super) fn look(p: [f32; 3], q: [f32; 3], value: f32, slope: [f32; 3], before: &Before, unit: f32) -> Trial {
    let (near, slide) = (LAST_STEP * unit, LAST_SLIDE * unit);
    let inverse = 1.0 / dot(slope, slope).sqrt();
    let n = [slope[0] * inverse, slope[1] * inverse, slope[2] * inverse];
    let e = value * inverse;
    let towards = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    let up = dot(towards, n);
    let tangent = [towards[0] - n[0] * up, towards[1] - n[1] * up, towards[2] - n[2] * up];
    let ahead = [towards[0] + n[0] * e, towards[1] + n[1] * e, towards[2] + n[2] * e];
    let (square, doubt) = (dot(ahead, ahead), 0.3 * e.abs());

    // A step that left the surface far (the more so the longer it was) has a merit not to be trusted.
    let strayed = e.abs() > 0.8 * before.residual + 0.3 * before.length;
    // Squares are compared: some callers have no use for the merit itself, and save the root.
    let room = before.merit * 1.0001 - doubt;
    let improves = (room >= 0.0) & (square <= room * room) & !strayed;
    let approaches = (before.residual > near) & (e.abs() < 0.8 * before.residual);
    let taken = (square < f32::INFINITY) & (doubt < f32::INFINITY) & (improves | approaches);
    let merit = square.sqrt() + doubt;

    // What a full step across the surface left of the residual tells how F bends along it, and so what the next step
    // will leave: e³ to the residual's square, which that step takes along.
    let straight = (before.merit < f32::INFINITY) & before.full & (before.length <= slide);
    let share_left = e * e / (before.residual * before.residual);
    let bends_little = straight & (share_left <= MOST_LEFT);
    let bend = select_unpredictable(bends_little, share_left, 0.0);
    let last_stride = bends_little & (e.abs() * share_left <= LAST_STRIDE * unit);
    let at_last = (e.abs() <= near) | last_stride;
    let lands = taken & at_last & (dot(tangent, tangent) <= slide * slide);
    Trial { normal: n, residual: e, towards, tangent, merit, taken, lands, landing: e + e * bend + up }
}

/// Judges all lanes' trial points by what was evaluated there, and sets the next ones.
#[multiversion(targets = "simd")]
pub(super) fn judge(lanes: &mut Lanes, gradients: &Gradients, unit: f32, reach: f32) {
    let [least, greatest] = lanes.bounds;
    for first in (0..lanes.points.len).step_by(WIDTH) {
        let p = load_axes(&lanes.p, first);
        let q: [Wide; 3] = load_each([&lanes.points.x, &lanes.points.y, &lanes.points.z], first);
        let value: Wide = load(&gradients.value, first);
        let slope: [Wide; 3] = load_each([&gradients.dx, &gradients.dy, &gradients.dz], first);
        let base = load_axes(&lanes.base, first);
        let normal_step = load_axes(&lanes.normal_step, first);
        let tangent_step = load_axes(&lanes.tangent_step, first);
        let [merit, residual]: [Wide; 2] = [load(&lanes.merit, first), load(&lanes.residual, first)];
        let [along, across]: [Wide; 2] = [load(&lanes.along, first), load(&lanes.across, first)];
        // What comes out is kept apart from what went in, and chosen without branches: else they become masked stores
        // (see `lane_math`).
        let [mut new_q, mut new_base, mut new_normal_step, mut new_tangent_step] = [[[0.0; WIDTH]; 3]; 4];
        let [mut new_merit, mut new_residual, mut new_along, mut new_across] = [[0.0; WIDTH]; 4];
        let mut landing = [[0.0; WIDTH]; 3];
        let mut height = [0.0; WIDTH];
        let mut verdicts = [0; WIDTH];
        for l in 0..WIDTH {
            let at = |a: &[Wide; 3]| [a[0][l], a[1][l], a[2][l]];
            let before = at(&tangent_step);
            let length = along[l] * dot(before, before).sqrt();
            let full = across[l] == 1.0;
            let known = Before { merit: merit[l], residual: residual[l], length, full };
            let Trial { normal: n, residual: e, tangent, merit: trial_merit, taken, lands, landing: ahead, .. } =
                look(at(&p), at(&q), value[l], at(&slope), &known, unit);

            // The share of the tangential step that would have brought it to zero, were its change linear in the
            // step (the secant of Barzilai and Borwein); the greatest where the steps grow, as on the far side of
            // a ball.
            let change = [before[0] - tangent[0], before[1] - tangent[1], before[2] - tangent[2]];
            let (gain, size) = (dot(before, change), dot(change, change));
            #[allow(clippy::manual_clamp, reason = "0 / 0 becomes 0.1 so; a clamp would keep it")]
            let secant = (along[l] * gain / size).max(0.1).min(GREATEST_SHARE);
            let share = select_unpredictable(gain <= 0.0, GREATEST_SHARE, secant);
            let first_of_all = (merit[l] == f32::INFINITY) | (dot(before, before) == 0.0) | (size == 0.0);
            let share = select_unpredictable(first_of_all, 1.0, share);

            // Already at a face of the region, and on its way out through it.
            let mut leaves = false;
            for axis in 0..3 {
                let trial = q[axis][l] - n[axis] * e + tangent[axis] * share;
                let beyond_least =
                    (trial < least[axis]) & (q[axis][l] == least[axis]) & (p[axis][l] - least[axis] >= reach);
                let beyond_greatest =
                    (trial > greatest[axis]) & (q[axis][l] == greatest[axis]) & (greatest[axis] - p[axis][l] >= reach);
                leaves |= beyond_least | beyond_greatest;
                let trial = within(trial, least[axis], greatest[axis]);
                new_base[axis][l] = select_unpredictable(taken, q[axis][l], base[axis][l]);
                new_q[axis][l] = select_unpredictable(taken, trial, q[axis][l]);
                new_normal_step[axis][l] = select_unpredictable(taken, -n[axis] * e, normal_step[axis][l]);
                new_tangent_step[axis][l] = select_unpredictable(taken, tangent[axis], tangent_step[axis][l]);
                landing[axis][l] = p[axis][l] - n[axis] * ahead;
            }
            new_merit[l] = select_unpredictable(taken, trial_merit, merit[l]);
            new_residual[l] = select_unpredictable(taken, e.abs(), residual[l]);
            new_along[l] = select_unpredictable(taken, share, along[l]);
            new_across[l] = select_unpredictable(taken, 1.0, across[l]);
            height[l] = ahead.abs();
            let not_landed = select_unpredictable(taken, verdict::MOVES, verdict::FAILS);
            let judged = select_unpredictable(lands, verdict::LANDS, not_landed);
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
