//! Feet on one branch alone: those at which the surface is crossed, in whole rows of eight.
//!
//! Where two parts of a union touch, F is 0 on the wall between them and positive on both sides: no surface (see
//! [`wall`](super::wall)). A foot on one branch counts where the query's side is right before it and the other behind.

use std::hint::select_unpredictable;

use multiversion::multiversion;

use crate::{
    distance::polish::{
        Polisher, Request, kernel,
        lanes::{Lane, Lanes},
        rows::{ROW, Rows},
        sides::{ACROSS, Resolution},
    },
    field::{BATCH, Evaluator, Points},
    grid::{BlockMask, mask},
};

use super::{Best, Queries, Scratch};

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
}

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
