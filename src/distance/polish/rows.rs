//! The first steps of many queries whose F is known: whole rows of eight lanes, so that they are copied, not gathered.
//!
//! Most queries land with them; the others go on one by one ([`Lanes::solve`]).

use crate::field::{BATCH, Gradients, Points};

use super::{
    Request,
    kernel::{self, verdict},
    lanes::{Lane, Lanes},
};

/// Lanes copied together: the voxels of a block along z.
const ROW: usize = 8;

impl Lanes {
    /// Finds the feet of queries on the zero set of what `evaluate` evaluates and `at_queries` holds already, where
    /// |F|/|∇F| is at most `far`. The results, by query, are in `foot` and `distance`.
    pub fn solve_known(
        &mut self,
        request: &Request,
        queries: &Points,
        at_queries: &Gradients,
        far: f32,
        gradients: &mut Gradients,
        mut evaluate: impl FnMut(&Points, &mut Gradients),
    ) {
        self.distance.fill(f32::INFINITY);
        let near = kernel::near(at_queries, queries.len, far);
        let mut rows = [0; BATCH / ROW];
        let mut count = 0;
        for row in 0..queries.len.div_ceil(ROW) {
            rows[count] = ROW * row;
            count += usize::from(near[row >> 3] >> (8 * (row & 7)) & 0xff != 0);
        }
        let rows = &rows[..count];
        if rows.is_empty() {
            self.points.len = 0;
            return;
        }
        self.set_bounds(request, queries);
        for (from, to) in [&queries.x, &queries.y, &queries.z].into_iter().zip(&mut self.p) {
            gather(rows, from, to);
        }
        gather(rows, &at_queries.value, &mut gradients.value);
        gather(rows, &at_queries.dx, &mut gradients.dx);
        gather(rows, &at_queries.dy, &mut gradients.dy);
        gather(rows, &at_queries.dz, &mut gradients.dz);
        self.points.len = ROW * count;
        kernel::begin(self, gradients);
        evaluate(&self.points, gradients);
        kernel::judge_first(self, gradients, request.unit, request.reach);
        for (from, to) in self.landing.iter().zip(&mut self.foot) {
            scatter(rows, from, to);
        }
        scatter(rows, &self.height, &mut self.distance);
        self.keep_moving(request, rows, queries.len);
        self.solve(request, gradients, evaluate);
    }

    /// Closes up the lanes of the first `queries` that are not done. `rows` tells where each row's queries are.
    fn keep_moving(&mut self, request: &Request, rows: &[usize], queries: usize) {
        let mut kept = 0;
        for (lanes, &row) in (0..).step_by(ROW).map(|first| first..first + ROW).zip(rows) {
            // The usual row is done as a whole.
            if self.verdict[lanes.clone()].iter().all(|&verdict| verdict >= verdict::DONE) {
                continue;
            }
            for (lane, query) in lanes.zip(row..queries) {
                self.query[lane] = query as u16;
                let moves = match self.verdict[lane] {
                    verdict::MOVES => true,
                    verdict::FAILS => self.retreat(request, lane),
                    _ => false,
                };
                if moves {
                    self.move_lane(lane, kept);
                    kept += 1;
                }
            }
        }
        self.points.len = kept;
    }
}

fn gather(rows: &[usize], from: &Lane, to: &mut Lane) {
    for (to, &row) in to.as_chunks_mut::<ROW>().0.iter_mut().zip(rows) {
        to.copy_from_slice(&from[row..row + ROW]);
    }
}

fn scatter(rows: &[usize], from: &Lane, to: &mut Lane) {
    for (from, &row) in from.as_chunks::<ROW>().0.iter().zip(rows) {
        to[row..row + ROW].copy_from_slice(from);
    }
}
