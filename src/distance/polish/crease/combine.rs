//! Creases and corners: feet on the common zeros of two or three branches.

use std::hint::select_unpredictable;

use multiversion::multiversion;

use crate::{
    distance::polish::{
        Polisher, Request,
        kernel::{self, dot, verdict, whole_passes},
        lanes::{Lane, Lanes},
        smooth::LAST_STEP,
    },
    field::{BATCH, Evaluator, Gradients},
    grid::mask,
};

use super::{Best, Queries, Scratch, matters};

/// At most this many branches, the nearest, are combined for one query: more make pairs and triples explode.
pub const COMBINED: usize = 16;

/// Newton steps for a crease or a corner. Planes take two; where more than this are needed two surfaces touch.
const STEPS: usize = 10;

/// The least squared sine of the angle between two branches that still make a crease.
const LEAST_SINE: f32 = 1e-4;

/// One query that asks for the foot on the common zeros of three branches, or of two, the last repeated. Packed, the
/// query last: many are sorted.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Demand(u64);

impl Demand {
    fn new([a, b, c]: [u16; 3], query: u16) -> Self {
        Self(u64::from(a) << 48 | u64::from(b) << 32 | u64::from(c) << 16 | u64::from(query))
    }

    fn branches(self) -> [u16; 3] {
        [(self.0 >> 48) as u16, (self.0 >> 32) as u16, (self.0 >> 16) as u16]
    }

    fn query(self) -> u16 {
        self.0 as u16
    }
}

impl Polisher {
    /// Lists the pairs of branches that are both nearer than the best foot.
    pub(super) fn demand_pairs(&mut self, request: &Request, branches: usize, len: usize, best: &Lane) {
        let Scratch { singles, pairs, .. } = &mut self.crease;
        pairs.clear();
        let most = matters(request);
        let mut limits = [0.0; BATCH];
        for (limit, best) in limits.iter_mut().zip(best).take(len) {
            *limit = best.min(most) - 1e-3 * request.unit;
        }
        let several = kernel::several(singles[..branches].iter().map(|single| &*single.distance), &limits, len);
        for query in mask::places(&several).take_while(|&query| query < len) {
            let mut near = [0u16; COMBINED];
            let mut count = 0;
            let limit = limits[query];
            let distance = |b: u16| singles[usize::from(b)].distance[query];
            for b in 0..branches as u16 {
                if distance(b) >= limit {
                    continue;
                }
                let place = near[..count].partition_point(|&other| distance(other) <= distance(b));
                if place < COMBINED {
                    count = (count + 1).min(COMBINED);
                    near[place..count].rotate_right(1);
                    near[place] = b;
                }
            }
            for (i, &b) in near[..count].iter().enumerate() {
                for &c in &near[i + 1..count] {
                    let (b, c) = (b.min(c), b.max(c));
                    pairs.push(Demand::new([b, c, c], query as u16));
                }
            }
        }
        pairs.sort_unstable();
    }

    /// Lists the triples all of whose three pairs are open.
    pub(super) fn demand_triples(&mut self, best: &Lane) {
        let Scratch { triples, open, .. } = &mut self.crease;
        triples.clear();
        open.sort_unstable_by_key(|demand| demand.0.rotate_right(16));
        for of_query in open.chunk_by(|a, b| a.query() == b.query()) {
            let query = of_query[0].query();
            if best[usize::from(query)] == 0.0 {
                continue;
            }
            for (i, first) in of_query.iter().enumerate() {
                let [b, c, _] = first.branches();
                for second in of_query[i + 1..].iter().take_while(|second| second.branches()[0] == b) {
                    let e = second.branches()[1];
                    if of_query.contains(&Demand::new([c, e, e], query)) {
                        triples.push(Demand::new([b, c, e], query));
                    }
                }
            }
        }
        triples.sort_unstable();
    }

    /// Solves the pairs (`order` 2) or triples (3) that were demanded, group by group of the same branches.
    pub(super) fn solve_demands(
        &mut self,
        evaluator: &mut dyn Evaluator,
        request: &Request,
        queries: &Queries,
        order: usize,
        best: &mut Best,
    ) {
        let demands = std::mem::take(if order == 2 { &mut self.crease.pairs } else { &mut self.crease.triples });
        for group in demands.chunk_by(|a, b| a.branches() == b.branches()) {
            self.solve_group(evaluator, request, queries, group, order, best);
        }
        *(if order == 2 { &mut self.crease.pairs } else { &mut self.crease.triples }) = demands;
    }

    fn solve_group(
        &mut self,
        evaluator: &mut dyn Evaluator,
        request: &Request,
        queries: &Queries,
        group: &[Demand],
        order: usize,
        best: &mut Best,
    ) {
        let branches = group[0].branches();
        let lanes = &mut *self.lanes;
        // The foot on the farther branch is the better start: the crease cannot be nearer than it.
        let singles = &self.crease.singles;
        lanes.load(request, queries.points, queries.points, group.iter().map(|demand| usize::from(demand.query())));
        for (lane, demand) in group.iter().enumerate() {
            let query = usize::from(demand.query());
            let farther = |a: &u16, b: &u16| {
                let distance = |c: &u16| singles[usize::from(*c)].distance[query];
                distance(a).total_cmp(&distance(b))
            };
            let start = branches.iter().copied().max_by(farther).unwrap_or(branches[0]);
            let start = singles[usize::from(start)].foot.offset(query);
            (lanes.points.x[lane], lanes.points.y[lane], lanes.points.z[lane]) = start.into();
        }
        for _ in 0..STEPS {
            if lanes.points.len == 0 {
                break;
            }
            for (part, &branch) in self.crease.parts[..order].iter_mut().zip(&branches) {
                evaluator.branch(usize::from(branch), &lanes.points, part);
            }
            let [one, two, three] = &self.crease.parts;
            if order == 2 {
                step_to_crease(lanes, [one, two], LAST_STEP * request.unit);
            } else {
                step_to_corner(lanes, [one, two, three], LAST_STEP * request.unit);
            }
            lanes.close_up();
        }
        self.judge_group(evaluator, request, queries, group, order, best);
    }

    /// Takes the feet of a group that lie on F = 0; pairs that do not stay open for triples.
    fn judge_group(
        &mut self,
        evaluator: &mut dyn Evaluator,
        request: &Request,
        queries: &Queries,
        group: &[Demand],
        order: usize,
        best: &mut Best,
    ) {
        let lanes = &mut *self.lanes;
        lanes.points.len = 0;
        self.crease.group.clear();
        for demand in group {
            let query = usize::from(demand.query());
            if lanes.distance[query] < best.distances[query].min(matters(request)) {
                self.crease.group.push(demand.query());
                lanes.points.push(lanes.foot.offset(query));
            }
        }
        if self.crease.group.is_empty() {
            return;
        }
        let branches = group[0].branches();
        let mut open = std::mem::take(&mut self.crease.open);
        let rejected = |query| {
            if order == 2 {
                open.push(Demand::new(branches, query));
            }
        };
        self.keep_feet(evaluator, request, queries, &branches[..order], rejected);
        self.crease.open = open;
        for (lane, &query) in self.crease.group.iter().enumerate() {
            let query = usize::from(query);
            best.take(query, self.lanes.points.offset(lane), self.lanes.distance[query]);
        }
    }
}

/// A branch at a lane's point: its unit gradient, and how far its zero set is along that.
#[inline(always)]
fn plane(part: &Gradients, lane: usize) -> ([f32; 3], f32) {
    let gradient = [part.dx[lane], part.dy[lane], part.dz[lane]];
    let slope = dot(gradient, gradient).sqrt();
    ([gradient[0] / slope, gradient[1] / slope, gradient[2] / slope], part.value[lane] / slope)
}

/// One Newton step of all lanes towards the nearest common zero of two branches: the point nearest to the query of the
/// line where both, linearised, vanish. Lanes between branches that hardly make a crease fail.
#[multiversion(targets = "simd")]
fn step_to_crease(lanes: &mut Lanes, [first, second]: [&Gradients; 2], last: f32) {
    for lane in 0..whole_passes(lanes.points.len) {
        let ([p, q], [(n1, r1), (n2, r2)]) = (lanes.places(lane), [plane(first, lane), plane(second, lane)]);
        let back = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        let cosine = dot(n1, n2);
        let sine = 1.0 - cosine * cosine;
        let (h1, h2) = (r1 + dot(n1, back), r2 + dot(n2, back));
        let (s1, s2) = ((h1 - cosine * h2) / sine, (h2 - cosine * h1) / sine);
        let next = [p[0] - n1[0] * s1 - n2[0] * s2, p[1] - n1[1] * s1 - n2[1] * s2, p[2] - n1[2] * s1 - n2[2] * s2];
        lanes.go(lane, next, sine < LEAST_SINE, last);
    }
}

/// The same towards the common zero of three branches.
#[multiversion(targets = "simd")]
fn step_to_corner(lanes: &mut Lanes, [first, second, third]: [&Gradients; 3], last: f32) {
    for lane in 0..whole_passes(lanes.points.len) {
        let [_, q] = lanes.places(lane);
        let [(n1, r1), (n2, r2), (n3, r3)] = [plane(first, lane), plane(second, lane), plane(third, lane)];
        let (n23, n31, n12) = (cross(n2, n3), cross(n3, n1), cross(n1, n2));
        let volume = dot(n1, n23);
        let along = |axis: usize| q[axis] - (n23[axis] * r1 + n31[axis] * r2 + n12[axis] * r3) / volume;
        lanes.go(lane, [along(0), along(1), along(2)], volume.abs() < LEAST_SINE, last);
    }
}

#[inline(always)]
fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - b[1] * a[2], a[2] * b[0] - b[2] * a[0], a[0] * b[1] - b[0] * a[1]]
}

impl Lanes {
    /// A lane's query p and its point q.
    #[inline(always)]
    fn places(&self, lane: usize) -> [[f32; 3]; 2] {
        let q = [self.points.x[lane], self.points.y[lane], self.points.z[lane]];
        [[self.p[0][lane], self.p[1][lane], self.p[2][lane]], q]
    }

    /// Moves a lane to its next point, within the bounds, or judges it done: landed there where the way is no more than
    /// the `last` step, or failed.
    #[inline(always)]
    fn go(&mut self, lane: usize, next: [f32; 3], fails: bool, last: f32) {
        let [p, q] = self.places(lane);
        let [least, greatest] = self.bounds;
        let mut at = [0.0; 3];
        for axis in 0..3 {
            // What is no number stays none.
            let next = if next[axis] < least[axis] { least[axis] } else { next[axis] };
            at[axis] = if next > greatest[axis] { greatest[axis] } else { next };
        }
        let (way, from_query) =
            ([at[0] - q[0], at[1] - q[1], at[2] - q[2]], [p[0] - at[0], p[1] - at[1], p[2] - at[2]]);
        let square = dot(way, way);
        let moves_or_lands = select_unpredictable(square <= last * last, verdict::LANDS, verdict::MOVES);
        let fails = fails | !square.is_finite();
        self.verdict[lane] = select_unpredictable(fails, verdict::FAILS, moves_or_lands);
        self.height[lane] = dot(from_query, from_query).sqrt();
        (self.points.x[lane], self.points.y[lane], self.points.z[lane]) = (at[0], at[1], at[2]);
    }

    /// Takes the feet of lanes that have landed, and closes up those that move on.
    fn close_up(&mut self) {
        let mut keep = [true; BATCH];
        let mut all = true;
        for lane in 0..self.points.len {
            keep[lane] = self.verdict[lane] == verdict::MOVES;
            all &= keep[lane];
            if self.verdict[lane] == verdict::LANDS {
                self.finish(lane, self.points.offset(lane).to_array(), self.height[lane]);
            }
        }
        if !all {
            self.compact(&keep);
        }
    }
}
