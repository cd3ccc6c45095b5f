//! The first step of many queries whose F is known: in whole rows of eight, and nothing kept of those that land.
//!
//! Most queries land with it; the others go on one by one ([`Lanes::solve`]).

use std::hint::select_unpredictable;

use multiversion::multiversion;

use crate::{
    field::{BATCH, Gradients, Points},
    grid::{BlockMask, mask},
};

use super::{
    Request,
    kernel::{Before, dot, load, load_each, look, store, within},
    lanes::Lanes,
    rows::{ROW, Rows},
};

/// How much nearer than |F|/|∇F| tells a foot may be at the beginning, for the step to count as a gain.
const DOUBT: f32 = 1.3;

impl Lanes {
    /// Finds the feet of those queries that are `near` on the zero set of what `evaluate` evaluates and `at_queries` holds
    /// already, and perhaps of others. The results, by query, are in `foot` and `distance`.
    pub fn solve_known(
        &mut self,
        request: &Request,
        queries: &Points,
        at_queries: &Gradients,
        near: &BlockMask,
        gradients: &mut Gradients,
        mut evaluate: impl FnMut(&Points, &mut Gradients),
    ) {
        self.distance.fill(f32::INFINITY);
        let rows = Rows::of(near, queries.len);
        self.points.len = rows.lanes();
        if self.points.len == 0 {
            return;
        }
        self.set_bounds(request, queries);
        begin(rows.starts(), queries, at_queries, self);
        evaluate(&self.points, gradients);
        let open = land(rows.starts(), queries, gradients, request, self);
        self.keep_open(&rows, queries, at_queries, &open, gradients);
        self.step(request, gradients);
        self.solve(request, gradients, evaluate);
    }

    /// Closes up the lanes that are still open, and what was evaluated there, as they are after a first step from
    /// their queries.
    fn keep_open(
        &mut self,
        rows: &Rows,
        queries: &Points,
        at_queries: &Gradients,
        open: &BlockMask,
        gradients: &mut Gradients,
    ) {
        let mut kept = 0;
        // Others of their rows have come along, and are too far.
        let meant: BlockMask = std::array::from_fn(|word| open[word] & rows.meant()[word]);
        for lane in mask::places(&meant) {
            let query = rows.query(lane);
            self.query[kept] = query as u16;
            let p = queries.offset(query).to_array();
            let slope = at_queries.gradient(query).to_array();
            let step = step_across(at_queries.value[query], slope, inverse_of(slope));
            for axis in 0..3 {
                (self.p[axis][kept], self.base[axis][kept]) = (p[axis], p[axis]);
                (self.normal_step[axis][kept], self.tangent_step[axis][kept]) = (step[axis], 0.0);
            }
            (self.along[kept], self.across[kept]) = (1.0, 1.0);
            self.residual[kept] = self.residual[lane];
            self.merit[kept] = DOUBT * self.residual[lane];
            for array in [&mut self.points.x, &mut self.points.y, &mut self.points.z] {
                array[kept] = array[lane];
            }
            let Gradients { value, dx, dy, dz } = &mut *gradients;
            for array in [value, dx, dy, dz] {
                array[kept] = array[lane];
            }
            kept += 1;
        }
        self.points.len = kept;
    }
}

/// One over |∇F|.
#[inline(always)]
fn inverse_of(slope: [f32; 3]) -> f32 {
    1.0 / dot(slope, slope).sqrt()
}

/// The step that would bring F to 0: −F∇F/|∇F|².
#[inline(always)]
fn step_across(value: f32, slope: [f32; 3], inverse: f32) -> [f32; 3] {
    let share = value * inverse * inverse;
    [-slope[0] * share, -slope[1] * share, -slope[2] * share]
}

/// Two rows side by side: a vector of the widest registers.
const PAIR: usize = 2 * ROW;

type Pair = [f32; PAIR];

/// Of two rows of queries the numbers by axis.
#[inline(always)]
fn load_pairs([x, y, z]: [&[f32; BATCH]; 3], starts: [usize; 2]) -> [Pair; 3] {
    [load_pair(x, starts), load_pair(y, starts), load_pair(z, starts)]
}

#[inline(always)]
fn load_pair(from: &[f32; BATCH], [one, other]: [usize; 2]) -> Pair {
    let (one, other): ([f32; ROW], [f32; ROW]) = (load(from, one), load(from, other));
    let mut pair = [0.0; PAIR];
    pair[..ROW].copy_from_slice(&one);
    pair[ROW..].copy_from_slice(&other);
    pair
}

/// Sets the trial points of the rows' queries: a step across the surface. Their residuals are those at the queries.
#[multiversion(targets = "simd")]
fn begin(rows: &[usize], queries: &Points, at: &Gradients, lanes: &mut Lanes) {
    let [least, greatest] = lanes.bounds;
    let Lanes { points, residual: residuals, .. } = lanes;
    for (to, pair) in (0..).step_by(PAIR).zip(rows.chunks(2)) {
        // Where one is left it stands for both; what comes of the second then is in lanes that nobody reads.
        let starts = [pair[0], pair[pair.len() - 1]];
        let p = load_pairs([&queries.x, &queries.y, &queries.z], starts);
        let slope = load_pairs([&at.dx, &at.dy, &at.dz], starts);
        let value = load_pair(&at.value, starts);
        let (mut trial, mut residual) = ([[0.0; PAIR]; 3], [0.0; PAIR]);
        for l in 0..PAIR {
            let slope = [slope[0][l], slope[1][l], slope[2][l]];
            let inverse = inverse_of(slope);
            let step = step_across(value[l], slope, inverse);
            for axis in 0..3 {
                trial[axis][l] = within(p[axis][l] + step[axis], least[axis], greatest[axis]);
            }
            residual[l] = value[l].abs() * inverse;
        }
        store(trial[0], &mut points.x, to);
        store(trial[1], &mut points.y, to);
        store(trial[2], &mut points.z, to);
        store(residual, residuals, to);
    }
}

/// Takes the feet of the rows' queries that land, by what was evaluated at their trial points, and returns the lanes
/// that go on: all but these and those whose foot is out of reach.
#[multiversion(targets = "simd")]
fn land(rows: &[usize], queries: &Points, gradients: &Gradients, request: &Request, lanes: &mut Lanes) -> BlockMask {
    let mut open = [0; BATCH];
    let Lanes { points, residual, foot: feet, distance, .. } = lanes;
    for (first, pair) in (0..).step_by(PAIR).zip(rows.chunks(2)) {
        let p = load_pairs([&queries.x, &queries.y, &queries.z], [pair[0], pair[pair.len() - 1]]);
        let q: [Pair; 3] = load_each([&points.x, &points.y, &points.z], first);
        let slope: [Pair; 3] = load_each([&gradients.dx, &gradients.dy, &gradients.dz], first);
        let value: Pair = load(&gradients.value, first);
        let residual: Pair = load(residual, first);
        let (mut foot, mut height, mut goes_on) = ([[0.0; PAIR]; 3], [0.0; PAIR], [0; PAIR]);
        for l in 0..PAIR {
            let at = |a: &[Pair; 3]| [a[0][l], a[1][l], a[2][l]];
            let before = Before { merit: DOUBT * residual[l], residual: residual[l], length: 0.0, full: true };
            let trial = look(at(&p), at(&q), value[l], at(&slope), &before, request.unit);
            for axis in 0..3 {
                foot[axis][l] = p[axis][l] - trial.normal[axis] * trial.landing;
            }
            height[l] = select_unpredictable(trial.lands, trial.landing.abs(), f32::INFINITY);
            // The foot is where F leads from q, but for what was left across and along the surface, twice over.
            let [x, y, z] = trial.tangent;
            let farthest = request.reach + 2.0 * (trial.residual.abs() + x.abs() + y.abs() + z.abs());
            let is_beyond = trial.taken & (dot(trial.towards, trial.towards) > farthest * farthest);
            goes_on[l] = u8::from(!trial.lands & !is_beyond);
        }
        for (half, &row) in (0..).step_by(ROW).zip(pair) {
            for (foot, feet) in foot.iter().zip([&mut feet.x, &mut feet.y, &mut feet.z]) {
                feet[row..row + ROW].copy_from_slice(&foot[half..half + ROW]);
            }
            distance[row..row + ROW].copy_from_slice(&height[half..half + ROW]);
            open[first + half..first + half + ROW].copy_from_slice(&goes_on[half..half + ROW]);
        }
    }
    mask::pack_first(&open, ROW * rows.len())
}
