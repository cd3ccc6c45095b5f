//! A rough distance, for what is only to be estimated: to points where F changes its sign on the edges of a coarse lattice, and
//! where a few steps of Newton's method lead from the middles of cells that may hold what slips through. No scene can name it.

use std::sync::Arc;

use glam::{DVec3, IVec3};

use super::closest_point::ClosestPoint as Exact;
use super::{Measured, Method, Request};
use crate::distance::Foot;
use crate::distance::nearest::{ClosestPoint, PointTree, Watch};
use crate::distance::octree::{BuildError, DistanceObject, Settings};
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Points};

/// Cells of the lattice along the longest side of the solid's box.
pub(crate) const CELLS: f64 = 24.0;

/// Steps of Newton's method, and what the last one may be, in cells.
const STEPS: usize = 4;
const SETTLED: f64 = 0.1;

/// The method.
pub struct Rough;

impl Method for Rough {
    fn name(&self) -> &'static str {
        "rough"
    }

    fn measure(&self, request: &Request<'_>, watch: &Watch<'_>) -> Result<Measured, BuildError> {
        let Request { field, solid, .. } = *request;
        let field = field.as_ref();
        let edge = solid.size().max_element() / CELLS;
        let mut seeds = crossings(request, edge);
        seeds.extend(slipped(request, edge));
        if seeds.is_empty() {
            return Exact.measure(request, watch);
        }
        let feet = RoughFeet { field, seeds: PointTree::new(seeds) };
        // A foot may be wrong by a cell: to follow it further would refine noise.
        let settings = Settings {
            tolerance: edge,
            tolerance_across: edge,
            memory_limit: request.settings.memory_limit,
            ..Settings::new(solid, edge)
        };
        let object = DistanceObject::build(&feet, &settings, watch)?;
        Ok(Measured::of(Arc::new(object)))
    }
}

/// Where F changes its sign along the lattice's edges, by linear interpolation.
fn crossings(request: &Request<'_>, edge: f64) -> Vec<DVec3> {
    let first = request.solid.min - 0.5 * edge;
    let count = (request.solid.size() / edge).ceil().as_ivec3() + 2;
    let place = |at: IVec3| first + at.as_dvec3() * edge;
    let number = |at: IVec3| ((at.x * count.y + at.y) * count.z + at.z) as usize;
    let all = || {
        (0..count.x).flat_map(move |x| (0..count.y).flat_map(move |y| (0..count.z).map(move |z| IVec3::new(x, y, z))))
    };
    let positions: Vec<DVec3> = all().map(place).collect();
    let mut values = Vec::with_capacity(positions.len());
    let mut evaluator = request.field.evaluator();
    values_at(&mut *evaluator, &positions, |value| values.push(value));
    let mut found = Vec::new();
    for at in all() {
        for axis in [IVec3::X, IVec3::Y, IVec3::Z] {
            let next = at + axis;
            if next.cmpge(count).any() {
                continue;
            }
            let [a, b] = [at, next].map(|at| f64::from(values[number(at)]));
            if (a < 0.0) != (b < 0.0) {
                let share = (a / (a - b)).clamp(0.0, 1.0);
                found.push(place(at) + axis.as_dvec3() * edge * if share.is_finite() { share } else { 0.5 });
            }
        }
    }
    found
}

/// Points of the surface near the middles of those cells that F's bounds do not rule out.
fn slipped(request: &Request<'_>, edge: f64) -> Vec<DVec3> {
    let mut evaluator = request.field.evaluator();
    let mut middles = Vec::new();
    add_middles(&mut *evaluator, request.solid, edge, &mut middles);
    let mut gradients = Box::<Gradients>::default();
    let mut found = Vec::new();
    for middles in middles.chunks(BATCH) {
        let mut positions = middles.to_vec();
        let mut last = vec![f64::INFINITY; positions.len()];
        for _ in 0..STEPS {
            evaluator.gradients(&Points::of_positions(&positions), &mut gradients);
            for (i, (position, last)) in positions.iter_mut().zip(&mut last).enumerate() {
                let slope = gradients.gradient(i).as_dvec3();
                let step = -slope * (f64::from(gradients.value[i]) / slope.length_squared());
                *last = if step.is_finite() { step.length() } else { f64::INFINITY };
                *position += if step.is_finite() { step.clamp_length_max(edge) } else { DVec3::ZERO };
            }
        }
        let is_found = |i: &usize| last[*i] <= SETTLED * edge && positions[*i].distance(middles[*i]) <= edge;
        found.extend((0..positions.len()).filter(is_found).map(|i| positions[i]));
    }
    found
}

/// The middles of a box's parts, no longer than an edge, in which F may vanish.
fn add_middles(evaluator: &mut dyn Evaluator, cell: Aabb, edge: f64, middles: &mut Vec<DVec3>) {
    evaluator.enter(&cell);
    let bounds = evaluator.bounds();
    if bounds.lo <= 0.0 && bounds.hi >= 0.0 {
        let axis = cell.size().max_position();
        if cell.size()[axis] <= edge {
            middles.push(cell.centre());
        } else {
            let (mut lower, mut upper) = (cell, cell);
            lower.max[axis] = cell.centre()[axis];
            upper.min[axis] = lower.max[axis];
            add_middles(evaluator, lower, edge, middles);
            add_middles(evaluator, upper, edge, middles);
        }
    }
    evaluator.leave();
}

/// F at positions, one after the other.
fn values_at(evaluator: &mut dyn Evaluator, positions: &[DVec3], mut take: impl FnMut(f32)) {
    let mut values = [0.0; BATCH];
    for chunk in positions.chunks(BATCH) {
        evaluator.values(&Points::of_positions(chunk), &mut values);
        values[..chunk.len()].iter().copied().for_each(&mut take);
    }
}

/// The nearest of the crossings, and F's sign.
struct RoughFeet<'a> {
    field: &'a dyn Field,
    seeds: PointTree,
}

impl ClosestPoint for RoughFeet<'_> {
    fn feet(&self, positions: &[DVec3], feet: &mut [Foot]) {
        let mut nearest = Vec::new();
        self.seeds.nearest_each(positions, &mut nearest);
        let mut evaluator = self.field.evaluator();
        let mut signs = Vec::with_capacity(positions.len());
        values_at(&mut *evaluator, positions, |value| signs.push(if value < 0.0 { -1.0 } else { 1.0 }));
        for (place, (foot, position)) in feet.iter_mut().zip(positions).enumerate() {
            let point = nearest.get(place).map_or(*position, |&seed| self.seeds.point(seed));
            let away = *position - point;
            let gradient = (away * signs[place]).normalize_or(DVec3::X);
            *foot = Foot { point, distance: signs[place] * away.length(), gradient, part: 0 };
        }
    }
}
