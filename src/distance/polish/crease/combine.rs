//! Creases and corners: feet on the common zeros of two or three branches.

use glam::Vec3;

use crate::{
    distance::polish::{
        Polisher, Request, kernel,
        lanes::{Lane, Lanes},
        smooth::LAST_STEP,
    },
    field::{BATCH, Evaluator, Gradients},
    grid::mask,
};

use super::{Best, Queries, Scratch, matters, offset};

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
        let several = kernel::several(singles[..branches].iter().map(|single| &single.distance), &limits, len);
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
            let start = offset(&singles[usize::from(start)].foot, query);
            (lanes.points.x[lane], lanes.points.y[lane], lanes.points.z[lane]) = start.into();
        }
        for _ in 0..STEPS {
            if lanes.points.len == 0 {
                break;
            }
            for (part, &branch) in self.crease.parts[..order].iter_mut().zip(&branches) {
                evaluator.branch(usize::from(branch), &lanes.points, part);
            }
            let mut keep = [true; BATCH];
            for (lane, keep) in keep.iter_mut().enumerate().take(lanes.points.len) {
                *keep = advance(lanes, request, &self.crease.parts[..order], lane);
            }
            lanes.compact(&keep);
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
                lanes.points.push(offset(&lanes.foot, query));
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

/// One Newton step of a lane towards the nearest common zero of two or three branches; false when it is done.
fn advance(lanes: &mut Lanes, request: &Request, parts: &[Box<Gradients>], lane: usize) -> bool {
    let q = lanes.points.offset(lane);
    let p = offset(&lanes.p, lane);
    let mut normals = [Vec3::ZERO; 3];
    let mut residuals = [0.0; 3];
    for ((normal, residual), part) in normals.iter_mut().zip(&mut residuals).zip(parts) {
        let gradient = part.gradient(lane);
        let slope = gradient.length();
        *normal = gradient / slope;
        *residual = part.value[lane] / slope;
    }
    let [n1, n2, n3] = normals;
    let next = if parts.len() == 2 {
        // The line where both linearised branches vanish; its point nearest to p.
        let cosine = n1.dot(n2);
        let sine = 1.0 - cosine * cosine;
        if sine < LEAST_SINE {
            return false;
        }
        let (h1, h2) = (residuals[0] + n1.dot(p - q), residuals[1] + n2.dot(p - q));
        p - n1 * ((h1 - cosine * h2) / sine) - n2 * ((h2 - cosine * h1) / sine)
    } else {
        let volume = n1.dot(n2.cross(n3));
        if volume.abs() < LEAST_SINE {
            return false;
        }
        q - (n2.cross(n3) * residuals[0] + n3.cross(n1) * residuals[1] + n1.cross(n2) * residuals[2]) / volume
    };
    let [least, greatest] = lanes.bounds.map(Vec3::from_array);
    let next = next.clamp(least, greatest);
    if !next.is_finite() {
        return false;
    }
    if (next - q).length_squared() <= (LAST_STEP * request.unit) * (LAST_STEP * request.unit) {
        lanes.finish(lane, next.to_array(), (p - next).length());
        return false;
    }
    (lanes.points.x[lane], lanes.points.y[lane], lanes.points.z[lane]) = next.into();
    true
}
