//! Feet on sheets and beside gaps too thin to be crossed by a step: where surfaces nearly touch, or do so in a point.
//!
//! A foot on one branch with F of one sign before and behind lies on a skin, on a wall, on a branch that is hidden, or on a
//! sheet thinner than the steps. Only the last is surface (see [`sides`](crate::distance::polish::sides)).

use glam::Vec3;

use crate::{
    distance::polish::{
        Polisher, Request,
        rows::Rows,
        sides::{ACROSS, is_uneven},
    },
    field::{BATCH, Evaluator},
    grid::{BlockMask, mask},
};

use super::{Best, Queries, STEEPER, Scratch};

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

impl Polisher {
    /// Takes those of the feet with F of one sign before and behind them that lie on a sheet, or beside a gap, thinner than
    /// the steps: all others lie on skins and walls, or are hidden.
    #[expect(clippy::too_many_arguments, reason = "what one judgement is made of")]
    pub(super) fn take_thin(
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
