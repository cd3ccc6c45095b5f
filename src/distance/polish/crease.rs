//! Closest points where several smooth branches meet: on a branch, on the crease of two, in the corner of three.
//!
//! The distance to a whole branch's zero set is a lower bound for the distance to the part of it that lies on F = 0.
//! So a branch's foot that lies on F = 0 beats everything farther, and creases matter only between branches whose
//! own feet are nearer than the best and do not lie on F = 0; corners only where creases failed in the same way.

mod combine;
mod single;
mod thin;

use glam::{DVec3, Vec3};

use crate::field::{BATCH, Evaluator, Gradients, Points};

pub use combine::COMBINED;
use combine::Demand;

use super::{
    FAR, Polisher, Request, kernel,
    lanes::{Lane, Lanes},
    sides::{ACROSS, Sides, Zeros},
    wall,
};

/// |F|/|∇F| up to which a candidate counts as lying on F = 0, in units. Smaller rejects true feet for the error of
/// their last step, larger lets feet overshoot a crease by as much.
const ON_SURFACE: f32 = 0.01;

/// How much steeper F may be than a branch of it, on the surface. R₀ operations have the slope of their one active
/// operand away from creases, and twice the sum of both at most on them. Smaller could reject true feet, larger
/// rejects fewer of the others before their gradient is asked for.
const STEEPER: f32 = 8.0;

/// In a region of more branches than this it pays to ask in smaller regions; in one of more than [`COMBINED`] it is
/// needed for feet to be exact.
pub const FEW: usize = 6;

/// How far beyond reach feet are still of use, in units.
const BEYOND: f32 = 0.5;

/// Feet on one branch alone, by query.
#[derive(Clone)]
struct Single {
    foot: Box<Points>,
    /// Infinity where the branch is out of reach.
    distance: Box<Lane>,
}

/// Scratch memory for the candidates of a batch.
pub(super) struct Scratch {
    singles: Vec<Single>,
    pairs: Vec<Demand>,
    triples: Vec<Demand>,
    /// Pairs whose foot is nearer than the best but not on F = 0, with a corner perhaps behind them.
    open: Vec<Demand>,
    group: Vec<u16>,
    parts: [Box<Gradients>; 3],
    /// The seeds given, and the queries whose seed lies on F = 0.
    seeds: Box<[Lane; 3]>,
    seeded: Vec<u16>,
    /// The branch that each seed lies on, and its |f|/|∇f| there.
    lies_on: Box<[u16; BATCH]>,
    residuals: Box<Lane>,
    /// F at candidates, or before and behind them.
    values: [Box<Lane>; 2],
    /// Places before or behind candidates.
    probes: Points,
    walls: wall::Scratch,
    sides: Sides,
    /// Zeros where two surfaces touch.
    touching: Zeros,
}

impl Default for Scratch {
    fn default() -> Self {
        let list = || Vec::with_capacity(BATCH);
        Self {
            singles: Vec::new(),
            pairs: list(),
            triples: list(),
            open: list(),
            group: Vec::with_capacity(BATCH),
            parts: Default::default(),
            seeds: Box::new([[0.0; BATCH]; 3]),
            seeded: Vec::with_capacity(BATCH),
            lies_on: Box::new([0; BATCH]),
            residuals: Box::new([0.0; BATCH]),
            values: [Box::new([0.0; BATCH]), Box::new([0.0; BATCH])],
            probes: Points::new(DVec3::ZERO),
            walls: wall::Scratch::default(),
            sides: Sides::new(),
            touching: Zeros::new(),
        }
    }
}

/// Whose feet are sought, and the side each is on.
pub(super) struct Queries<'a> {
    pub points: &'a Points,
    pub inside: &'a [bool; BATCH],
}

/// The best foot so far of each query.
struct Best<'a> {
    feet: &'a mut Points,
    distances: &'a mut Lane,
}

impl Best<'_> {
    fn take(&mut self, query: usize, foot: Vec3, distance: f32) {
        if distance < self.distances[query] {
            self.distances[query] = distance;
            (self.feet.x[query], self.feet.y[query], self.feet.z[query]) = foot.into();
        }
    }
}

impl Polisher {
    /// Finds closest points from scratch; [`Self::take_seeds`] may have found some already.
    pub(super) fn crease_closest(
        &mut self,
        evaluator: &mut dyn Evaluator,
        request: &Request,
        queries: &Points,
        inside: &[bool; BATCH],
        feet: &mut Points,
        distances: &mut Lane,
    ) {
        let queries = &Queries { points: queries, inside };
        let branches = evaluator.branches();
        while self.crease.singles.len() < branches {
            let (foot, distance) = (Box::new(Points::new(DVec3::ZERO)), Box::new([f32::INFINITY; BATCH]));
            self.crease.singles.push(Single { foot, distance });
        }
        for branch in 0..branches {
            self.find_single(evaluator, request, queries, branch);
            let single = &self.crease.singles[branch].distance;
            let nearer = kernel::nearer(single, distances, matters(request), queries.points.len);
            self.judge_single(evaluator, request, queries, branch, &nearer, &mut Best { feet, distances });
        }
        let mut best = Best { feet, distances };
        self.demand_pairs(request, branches, queries.points.len, best.distances);
        self.crease.open.clear();
        self.solve_demands(evaluator, request, queries, 2, &mut best);
        self.demand_triples(best.distances);
        self.solve_demands(evaluator, request, queries, 3, &mut best);
        self.follow_seeds(evaluator, request, queries, branches, &mut best);
    }

    /// Starts without seeds.
    pub(super) fn forget_seeds(&mut self, distances: &mut Lane) {
        distances.fill(f32::INFINITY);
        self.crease.seeded.clear();
    }

    /// Seeds that lie on F = 0 are the first candidates; a query is no seed of its own.
    pub(super) fn take_seeds(
        &mut self,
        evaluator: &mut dyn Evaluator,
        request: &Request,
        queries: &Points,
        feet: &Points,
        distances: &mut Lane,
    ) {
        self.forget_seeds(distances);
        evaluator.gradients(feet, &mut self.gradients);
        for i in 0..queries.len {
            let given = feet.offset(i) != queries.offset(i);
            if given && on_surface(&self.gradients, i, f32::NAN, request) {
                distances[i] = (queries.offset(i) - feet.offset(i)).length();
                for (axis, offset) in feet.offset(i).to_array().into_iter().enumerate() {
                    self.crease.seeds[axis][i] = offset;
                }
                self.crease.seeded.push(i as u16);
            }
        }
    }

    /// The foot of each query on one branch's own zero set.
    fn find_single(&mut self, evaluator: &mut dyn Evaluator, request: &Request, queries: &Queries, branch: usize) {
        let Scratch { singles, parts, .. } = &mut self.crease;
        evaluator.branch(branch, queries.points, &mut parts[0]);
        let evaluate = |points: &Points, out: &mut Gradients| evaluator.branch(branch, points, out);
        let near = kernel::near(&parts[0], queries.points.len, FAR * request.reach);
        self.lanes.solve_known(request, queries.points, &parts[0], &near, &mut self.gradients, evaluate);
        // The results change hands, nothing is copied.
        std::mem::swap(&mut singles[branch].foot, &mut self.lanes.foot);
        std::mem::swap(&mut singles[branch].distance, &mut self.lanes.distance);
    }

    /// Leaves of the candidates (`self.lanes.points`, of the queries `self.crease.group`) on the common zeros of
    /// `branches` those where the solid ends.
    fn keep_feet(
        &mut self,
        evaluator: &mut dyn Evaluator,
        request: &Request,
        queries: &Queries,
        branches: &[u16],
        mut rejected: impl FnMut(u16),
    ) {
        let Scratch { parts, group, values: [values, _], walls, .. } = &mut self.crease;
        let points = &mut self.lanes.points;
        // What F may be by rounding, by its slope.
        let rounding = request.resolution().share() * (ACROSS * request.unit);
        evaluator.branch(usize::from(branches[0]), points, &mut parts[0]);
        keep_near_surface(evaluator, request, points, group, &mut parts[0], values, &mut rejected);
        if group.is_empty() {
            return;
        }
        evaluator.gradients(points, &mut self.gradients);
        let gradients = &self.gradients;
        let (mut roundings, mut kept) = ([0.0; BATCH], 0);
        let lies_on = |lane| {
            let slope = parts[0].gradient(lane).length();
            let lies_on = on_surface(gradients, lane, slope, request);
            roundings[kept] = slope.max(gradients.gradient(lane).length()) * rounding;
            kept += usize::from(lies_on);
            lies_on
        };
        keep_lanes(points, group, lies_on, &mut rejected);
        walls.leave_out(evaluator, request, queries, branches, parts, points, group, &roundings, values, rejected);
    }

    /// Where a seed is still the best (the branches' own feet, found from the query, are local), moves it to the
    /// foot on the branch it lies on.
    fn follow_seeds(
        &mut self,
        evaluator: &mut dyn Evaluator,
        request: &Request,
        queries: &Queries,
        branches: usize,
        best: &mut Best,
    ) {
        let Scratch { seeds, seeded, lies_on, residuals, parts, .. } = &mut self.crease;
        seeded.retain(|&query| best.feet.offset(usize::from(query)) == offset(seeds, usize::from(query)));
        if seeded.is_empty() {
            return;
        }
        // Where no query is near any branch, nothing has set the origin yet: that of an earlier batch stands there.
        self.lanes.set_bounds(request, queries.points);
        let points = &mut self.lanes.points;
        points.len = 0;
        for &query in seeded.iter() {
            let i = usize::from(query);
            points.push(offset(seeds, i));
            // No branch: one that an earlier batch left here would be followed where none has a slope at the seed.
            (residuals[i], lies_on[i]) = (f32::INFINITY, u16::MAX);
        }
        for branch in 0..branches {
            evaluator.branch(branch, points, &mut parts[0]);
            for (lane, &query) in seeded.iter().enumerate() {
                let query = usize::from(query);
                let residual = quotient(&parts[0], lane);
                if residual < residuals[query] {
                    (residuals[query], lies_on[query]) = (residual, branch as u16);
                }
            }
        }
        for branch in 0..branches {
            let Scratch { seeded, lies_on, group, singles, .. } = &mut self.crease;
            group.clear();
            group.extend(seeded.iter().filter(|&&query| usize::from(lies_on[usize::from(query)]) == branch));
            if group.is_empty() {
                continue;
            }
            self.lanes.load(request, queries.points, best.feet, group.iter().map(|&i| usize::from(i)));
            self.lanes.solve(request, &mut self.gradients, |points, out| evaluator.branch(branch, points, out));
            copy_single(&self.lanes, group, &mut singles[branch]);
            let mut nearer = [0; 8];
            for query in group.iter().map(|&query| usize::from(query)) {
                let is_nearer = singles[branch].distance[query] < best.distances[query];
                nearer[query >> 6] |= u64::from(is_nearer) << (query & 63);
            }
            self.judge_single(evaluator, request, queries, branch, &nearer, best);
        }
    }
}

/// Leaves out candidates whose F is far from 0 by the slope of the branch they lie on: most of them, for a fraction of
/// what the gradient of F costs. `points`, `group` and the branch's `part` go lane by lane.
fn keep_near_surface(
    evaluator: &mut dyn Evaluator,
    request: &Request,
    points: &mut Points,
    group: &mut Vec<u16>,
    part: &mut Gradients,
    values: &mut Lane,
    mut rejected: impl FnMut(u16),
) {
    evaluator.values(points, values);
    let mut kept = 0;
    for lane in 0..group.len() {
        let slope = part.gradient(lane).length();
        // A branch without a slope, or a value that is no number, is for the full test.
        if values[lane].abs() > STEEPER * ON_SURFACE * request.unit * slope {
            rejected(group[lane]);
            continue;
        }
        group[kept] = group[lane];
        (points.x[kept], points.y[kept], points.z[kept]) = (points.x[lane], points.y[lane], points.z[lane]);
        (part.dx[kept], part.dy[kept], part.dz[kept]) = (part.dx[lane], part.dy[lane], part.dz[lane]);
        kept += 1;
    }
    group.truncate(kept);
    points.len = kept;
}

/// Leaves out the candidates whose lanes fail a test. `points` and `group` go lane by lane.
pub(super) fn keep_lanes(
    points: &mut Points,
    group: &mut Vec<u16>,
    mut passes: impl FnMut(usize) -> bool,
    mut rejected: impl FnMut(u16),
) {
    let mut kept = 0;
    for lane in 0..group.len() {
        if passes(lane) {
            group[kept] = group[lane];
            (points.x[kept], points.y[kept], points.z[kept]) = points.offset(lane).into();
            kept += 1;
        } else {
            rejected(group[lane]);
        }
    }
    group.truncate(kept);
    points.len = kept;
}

fn copy_single(lanes: &Lanes, group: &[u16], single: &mut Single) {
    for &query in group {
        let i = usize::from(query);
        single.distance[i] = lanes.distance[i];
        let (to, from) = (&mut single.foot, &lanes.foot);
        (to.x[i], to.y[i], to.z[i]) = (from.x[i], from.y[i], from.z[i]);
    }
}

/// How near feet must be to matter: neighbours that are in reach may still take those a little beyond it.
fn matters(request: &Request) -> f32 {
    request.reach + BEYOND * request.unit
}

/// |F|/|∇F| at a point; NaN where both vanish.
fn quotient(at: &Gradients, lane: usize) -> f32 {
    at.value[lane].abs() / at.gradient(lane).length()
}

/// Whether F = 0 at a point. Where F has no gradient there, `slope` (a branch's) stands in for |∇F|.
fn on_surface(at: &Gradients, lane: usize, slope: f32, request: &Request) -> bool {
    let own = at.gradient(lane).length();
    let slope = if own > 0.0 && own.is_finite() { own } else { slope };
    at.value[lane].abs() <= ON_SURFACE * request.unit * slope
}

fn offset(arrays: &[Lane; 3], i: usize) -> Vec3 {
    Vec3::new(arrays[0][i], arrays[1][i], arrays[2][i])
}
