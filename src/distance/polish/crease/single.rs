//! Feet on one branch alone: those at which the surface is crossed, in whole rows of eight.
//!
//! Where two parts of a union touch, F is 0 on the wall between them and positive on both sides: no surface (see
//! [`wall`](super::wall)). A foot on one branch counts where the query's side is right before it and the other behind.

use std::hint::select_unpredictable;

use glam::Vec3;
use multiversion::multiversion;

use crate::{
    distance::polish::{
        Polisher, Request, kernel,
        lanes::{Lane, Lanes},
        rows::{ROW, Rows},
        sides::{ACROSS, Resolution, is_uneven},
    },
    field::{BATCH, Evaluator, Points},
    grid::{BlockMask, mask},
};

use super::{Best, Queries, STEEPER, Scratch};

impl Polisher {
    /// Takes the feet of the candidates on one branch at which the surface is crossed; they are nearer than the best.
    pub(super) fn judge_single(
        &mut self,
        evaluator: &mut dyn Evaluator,
        request: &Request,
        queries: &Queries,
        branch: usize,
        candidates: &BlockMask,
        best: &mut Best,
    ) {
        let rows = Rows::of(candidates, queries.points.len);
        if rows.lanes() == 0 {
            return;
        }
        let lanes = &mut *self.lanes;
        let Scratch { singles, parts, values: [behind, before], probes, .. } = &mut self.crease;
        let (feet, distances) = (&*singles[branch].foot, &*singles[branch].distance);
        let feet = [&feet.x, &feet.y, &feet.z];
        lanes.set_bounds(request, queries.points);
        lanes.points.len = rows.lanes();
        rows.gather(feet, [&mut lanes.points.x, &mut lanes.points.y, &mut lanes.points.z]);
        let [x, y, z] = &mut lanes.p;
        rows.gather([&queries.points.x, &queries.points.y, &queries.points.z], [x, y, z]);
        kernel::steps_onward(lanes, ACROSS * request.unit);
        // A query on the surface has no way to its foot, but a normal.
        let on_surface = without_step(lanes, rows.meant());
        if on_surface != [0; 8] {
            evaluator.branch(branch, &lanes.points, &mut parts[0]);
            for lane in mask::places(&on_surface) {
                let outward = if queries.inside[rows.query(lane)] { -ACROSS } else { ACROSS } * request.unit;
                let step = parts[0].gradient(lane).normalize_or_zero() * outward;
                for (steps, step) in lanes.normal_step.iter_mut().zip(step.to_array()) {
                    steps[lane] = step;
                }
            }
        }
        (probes.origin, probes.len) = (lanes.points.origin, lanes.points.len);
        kernel::stepped(lanes, 1.0, probes);
        evaluator.values(probes, behind);
        kernel::stepped(lanes, -1.0, probes);
        evaluator.values(probes, before);
        let resolution = request.resolution();
        let one_sided = take_crossed(&rows, queries.inside, [before, behind], resolution, feet, distances, best);
        if one_sided != [0; 8] {
            self.take_thin(evaluator, request, queries, branch, &rows, &one_sided, best);
        }
    }

    /// Takes those of the feet with F of one sign before and behind them that lie on a sheet, or beside a gap, thinner than
    /// the steps: all others lie on skins and walls, or are hidden.
    #[expect(clippy::too_many_arguments, reason = "what one judgement is made of")]
    fn take_thin(
        &mut self,
        evaluator: &mut dyn Evaluator,
        request: &Request,
        queries: &Queries,
        branch: usize,
        rows: &Rows,
        one_sided: &BlockMask,
        best: &mut Best,
    ) {
        let lanes = &*self.lanes;
        let Scratch { parts, values: [behind, before], sides, .. } = &mut self.crease;
        evaluator.branch(branch, &lanes.points, &mut parts[0]);
        sides.zeros.clear(lanes.points.origin);
        let mut lane_of = [0; BATCH];
        for lane in mask::places(one_sided) {
            // The others are hidden: F is far from 0 there by the slope of the branch.
            let near = STEEPER * ACROSS * request.unit * parts[0].gradient(lane).length();
            if before[lane].abs().max(behind[lane].abs()) <= near {
                let [x, y, z] = &lanes.normal_step;
                lane_of[sides.zeros.points.len] = lane;
                sides.zeros.push(rows.query(lane), lanes.points.offset(lane), Vec3::new(x[lane], y[lane], z[lane]));
            }
        }
        if sides.zeros.points.len == 0 {
            return;
        }
        // So are those at which F is not 0.
        let (resolution, mut uneven) = (request.resolution(), false);
        let mut at_zeros = [0.0; BATCH];
        evaluator.values(&sides.zeros.points, &mut at_zeros);
        sides.zeros.keep(|zero| {
            let (before, behind) = (before[lane_of[zero]], behind[lane_of[zero]]);
            let is_zero = at_zeros[zero].abs() <= ZERO * before.abs().max(behind.abs());
            uneven |= is_zero && is_uneven(before, behind, resolution);
            is_zero
        });
        if self.crease.sides.zeros.points.len == 0 || !self.any_sheet(evaluator, request, queries, branch, uneven) {
            return;
        }
        let bounds = self.lanes.bounds.map(Vec3::from_array);
        let Scratch { singles, sides, .. } = &mut self.crease;
        let crossed = sides.crossed(evaluator, resolution, bounds, |query| queries.inside[query]);
        for lane in (0..sides.zeros.points.len).filter(|&lane| crossed[lane]) {
            let query = usize::from(sides.zeros.of[lane]);
            best.take(query, sides.zeros.points.offset(lane), singles[branch].distance[query]);
        }
        sides.zeros.keep(|lane| !crossed[lane]);
        if sides.zeros.points.len > 0 {
            self.take_beside(evaluator, request, queries, branch, best);
        }
    }

    /// Whether there is a sheet at some of the zeros (in `sides`), or beside them. The usual answer is no: pieces of a union
    /// share a wall, which is flat. So only a few zeros are looked at, all places in one batch.
    fn any_sheet(
        &mut self,
        evaluator: &mut dyn Evaluator,
        request: &Request,
        queries: &Queries,
        branch: usize,
        uneven: bool,
    ) -> bool {
        let Scratch { parts: [part, ..], sides, touching, .. } = &mut self.crease;
        touching.clone_from(&sides.zeros);
        sides.zeros.clear(touching.points.origin);
        let stride = touching.points.len.div_ceil(SAMPLES);
        for lane in (0..touching.points.len).step_by(stride) {
            let (at, onward) = (touching.points.offset(lane), touching.step(lane));
            sides.zeros.push(touching.of[lane].into(), at, onward);
            for direction in 0..DIRECTIONS {
                let point = at + beside(onward, direction) * (BESIDE * request.unit);
                sides.zeros.push(touching.of[lane].into(), point, onward);
            }
        }
        let bounds = self.lanes.bounds.map(Vec3::from_array);
        evaluator.branch(branch, &sides.zeros.points, part);
        sides.zeros.project(part, bounds);
        let (resolution, len) = (request.resolution(), sides.zeros.points.len);
        let any = (uneven || sides.any_uneven(evaluator, resolution, bounds))
            && sides.crossed(evaluator, resolution, bounds, |query| queries.inside[query])[..len].contains(&true);
        sides.zeros.clone_from(touching);
        any
    }

    /// Where two surfaces touch in a point or along a curve, a sheet begins beside it: takes the points nearest to the zeros
    /// (in `sides`) at which it has a thickness.
    fn take_beside(
        &mut self,
        evaluator: &mut dyn Evaluator,
        request: &Request,
        queries: &Queries,
        branch: usize,
        best: &mut Best,
    ) {
        let Scratch { parts: [part, ..], sides, touching, .. } = &mut self.crease;
        touching.clone_from(&sides.zeros);
        let resolution = request.resolution();
        let bounds = self.lanes.bounds.map(Vec3::from_array);
        for direction in 0..DIRECTIONS {
            let mut open = [true; BATCH];
            let mut reach = BESIDE * request.unit;
            for _ in 0..HALVINGS {
                sides.zeros.clear(touching.points.origin);
                let mut from = [0; BATCH];
                for lane in (0..touching.points.len).filter(|&lane| open[lane]) {
                    let onward = touching.step(lane);
                    from[sides.zeros.points.len] = lane;
                    let point = touching.points.offset(lane) + beside(onward, direction) * reach;
                    sides.zeros.push(touching.of[lane].into(), point, onward);
                }
                if sides.zeros.points.len == 0 {
                    break;
                }
                evaluator.branch(branch, &sides.zeros.points, part);
                sides.zeros.project(part, bounds);
                let crossed = sides.crossed(evaluator, resolution, bounds, |query| queries.inside[query]);
                open = [false; BATCH];
                for lane in (0..sides.zeros.points.len).filter(|&lane| crossed[lane]) {
                    let query = usize::from(sides.zeros.of[lane]);
                    let point = sides.zeros.points.offset(lane);
                    best.take(query, point, (queries.points.offset(query) - point).length());
                    open[from[lane]] = true;
                }
                reach *= 0.5;
            }
        }
    }
}

/// A unit vector square to a step, in one of the directions.
fn beside(step: Vec3, direction: usize) -> Vec3 {
    let (u, v) = step.normalize_or(Vec3::Z).any_orthonormal_pair();
    u * SINES[(direction + DIRECTIONS / 4) % DIRECTIONS] + v * SINES[direction]
}

/// F at a zero, by what it is a step away. Less rejects zeros that are a little off, more takes what lies beside them.
const ZERO: f32 = 0.2;

/// So many zeros of a batch are looked at first. Fewer miss sheets in blocks where there are walls too.
const SAMPLES: usize = 4;

/// How far beside a place where two surfaces touch a sheet is looked for first, in units, and how often half as far after
/// that. Farther meets other parts of the surface; less misses what two large balls leave between them.
const BESIDE: f32 = 0.5;
/// See [`BESIDE`].
const HALVINGS: usize = 5;

/// In how many directions.
const DIRECTIONS: usize = 8;

/// Their sines.
const SINES: [f32; DIRECTIONS] = {
    use std::f32::consts::FRAC_1_SQRT_2 as HALF;
    [0.0, HALF, 1.0, HALF, 0.0, -HALF, -1.0, -HALF]
};

/// Of some lanes those that have no step.
#[multiversion(targets = "simd")]
fn without_step(lanes: &Lanes, of: &BlockMask) -> BlockMask {
    let [x, y, z] = &lanes.normal_step;
    let mut none = [0; BATCH];
    for i in 0..kernel::whole_passes(lanes.points.len) {
        none[i] = u8::from((x[i] == 0.0) & (y[i] == 0.0) & (z[i] == 0.0));
    }
    let none = mask::pack_first(&none, lanes.points.len);
    std::array::from_fn(|word| none[word] & of[word])
}

/// Takes the feet of those queries of the rows that have F of their own side before them and of the other behind. Returns
/// the lanes that have F of their own side on both.
#[multiversion(targets = "simd")]
fn take_crossed(
    rows: &Rows,
    inside: &[bool; BATCH],
    [before, behind]: [&Lane; 2],
    resolution: Resolution,
    feet: [&Lane; 3],
    distances: &Lane,
    best: &mut Best,
) -> BlockMask {
    let mut one_sided = [0; BATCH];
    let share = resolution.share();
    for (first, &row) in (0..).step_by(ROW).zip(rows.starts()) {
        let meant = rows.meant()[first >> 6] >> (first & 63);
        let mut taken = [false; ROW];
        for l in 0..ROW {
            let inside = inside[row + l];
            let (before, behind) = (before[first + l], behind[first + l]);
            let is_other = |value: f32, other: f32| ((value >= 0.0) != inside) & (value.abs() > share * other.abs());
            let comes = !is_other(before, behind) & (meant >> l & 1 == 1);
            let leaves = is_other(behind, before);
            taken[l] = comes & leaves;
            one_sided[first + l] = u8::from(comes & !leaves);
        }
        let Points { x, y, z, .. } = &mut *best.feet;
        for (from, to) in feet.into_iter().chain([distances]).zip([x, y, z, &mut *best.distances]) {
            let (new, old): ([f32; ROW], [f32; ROW]) = (kernel::load(from, row), kernel::load(to, row));
            let mut chosen = [0.0; ROW];
            for l in 0..ROW {
                chosen[l] = select_unpredictable(taken[l], new[l], old[l]);
            }
            kernel::store(chosen, to, row);
        }
    }
    mask::pack_first(&one_sided, rows.lanes())
}
