//! The points of a batch that are still moving, packed densely so that every evaluation is of live points only.

use crate::field::{BATCH, Points};

use super::{Request, kernel::verdict};

pub(super) type Lane = [f32; BATCH];

/// Structure of arrays over the live points; `points.len` of them. Offsets are from `points.origin`.
#[derive(Clone)]
pub(super) struct Lanes {
    /// Which query each lane belongs to.
    pub query: [u16; BATCH],
    /// The trial points, where F is evaluated next.
    pub points: Points,
    /// The queries p.
    pub p: [Lane; 3],
    /// The last accepted points.
    pub base: [Lane; 3],
    /// The step from `base` that would bring F to 0: −F∇F/|∇F|².
    pub normal_step: [Lane; 3],
    /// The step from `base` along the surface towards p: p − q without its part along ∇F.
    pub tangent_step: [Lane; 3],
    /// What a step must make less, at `base`: see [`Lanes::solve`].
    pub merit: Lane,
    /// |F|/|∇F| at `base`.
    pub residual: Lane,
    /// The fractions taken of the steps along and across the surface.
    pub along: Lane,
    /// See `along`.
    pub across: Lane,
    /// What became of the last trial points, and where those that landed did.
    pub verdict: [u8; BATCH],
    /// See `verdict`.
    pub landing: [Lane; 3],
    /// See `verdict`.
    pub height: Lane,
    /// The least and greatest offsets at which F may be evaluated.
    pub bounds: [[f32; 3]; 2],
    /// Results: feet and distances by query, and which queries were asked for.
    pub foot: Box<Points>,
    /// Infinity where none was found.
    pub distance: Box<Lane>,
    /// The queries loaded, whose results `store` copies out.
    pub asked: [u16; BATCH],
    /// How many of `asked` there are.
    pub asked_len: usize,
}

impl Default for Lanes {
    fn default() -> Self {
        const ZERO: Lane = [0.0; BATCH];
        Self {
            query: [0; BATCH],
            points: Points::new(glam::DVec3::ZERO),
            p: [ZERO; 3],
            base: [ZERO; 3],
            normal_step: [ZERO; 3],
            tangent_step: [ZERO; 3],
            merit: ZERO,
            residual: ZERO,
            along: ZERO,
            across: ZERO,
            verdict: [verdict::MOVES; BATCH],
            landing: [ZERO; 3],
            height: ZERO,
            bounds: [[0.0; 3]; 2],
            foot: Box::new(Points::new(glam::DVec3::ZERO)),
            distance: Box::new(ZERO),
            asked: [0; BATCH],
            asked_len: 0,
        }
    }
}

impl Lanes {
    /// Starts the chosen queries from their seeds.
    pub fn load(
        &mut self,
        request: &Request,
        queries: &Points,
        seeds: &Points,
        chosen: impl IntoIterator<Item = usize>,
    ) {
        self.set_bounds(request, queries);
        let mut n = 0;
        for i in chosen {
            self.query[n] = i as u16;
            self.asked[n] = i as u16;
            self.distance[i] = f32::INFINITY;
            (self.p[0][n], self.p[1][n], self.p[2][n]) = (queries.x[i], queries.y[i], queries.z[i]);
            (self.points.x[n], self.points.y[n], self.points.z[n]) = (seeds.x[i], seeds.y[i], seeds.z[i]);
            self.merit[n] = f32::INFINITY;
            self.residual[n] = f32::INFINITY;
            self.along[n] = 1.0;
            self.across[n] = 1.0;
            n += 1;
        }
        self.points.len = n;
        self.asked_len = n;
    }

    /// Keeps trial points, as offsets from the queries' origin, in the request's region.
    pub fn set_bounds(&mut self, request: &Request, queries: &Points) {
        let least = (request.region.min - queries.origin).as_vec3().to_array();
        let greatest = (request.region.max - queries.origin).as_vec3().to_array();
        self.bounds = [least, greatest];
        self.points.origin = queries.origin;
    }

    /// Copies the results of the queries that were loaded to their places.
    pub fn store(&self, feet: &mut Points, distances: &mut Lane) {
        for &query in &self.asked[..self.asked_len] {
            let i = usize::from(query);
            distances[i] = self.distance[i];
            if self.distance[i] < f32::INFINITY {
                (feet.x[i], feet.y[i], feet.z[i]) = self.foot.offset(i).into();
            }
        }
    }

    /// Records the result of a lane.
    pub fn finish(&mut self, lane: usize, foot: [f32; 3], distance: f32) {
        let i = usize::from(self.query[lane]);
        self.distance[i] = distance;
        (self.foot.x[i], self.foot.y[i], self.foot.z[i]) = foot.into();
    }

    /// Drops the lanes that are not kept, the others close up in order.
    pub fn compact(&mut self, keep: &[bool; BATCH]) {
        let mut to = 0;
        for from in 0..self.points.len {
            if !keep[from] {
                continue;
            }
            self.move_lane(from, to);
            to += 1;
        }
        self.points.len = to;
    }

    pub fn move_lane(&mut self, from: usize, to: usize) {
        if to == from {
            return;
        }
        self.query[to] = self.query[from];
        let points = &mut self.points;
        (points.x[to], points.y[to], points.z[to]) = (points.x[from], points.y[from], points.z[from]);
        for axis in 0..3 {
            for array in [&mut self.p, &mut self.base, &mut self.normal_step, &mut self.tangent_step] {
                array[axis][to] = array[axis][from];
            }
        }
        for array in [&mut self.merit, &mut self.residual, &mut self.along, &mut self.across] {
            array[to] = array[from];
        }
    }
}
