//! Closest points on a surface, wherever the asker stands.
//!
//! [`ClosestPoint`] is what a distance object is built from. Meshes answer by themselves; any other
//! field does through [`FieldFeet`]: feet of the band around its zero set are seeds, the nearest seed is
//! found in a k-d tree, and the answer is polished on the true field around that seed.
//!
//! **Guaranteed:** an answer lies on the surface and is no farther than the nearest seed; seeds stand about a
//! spacing apart on all of the surface that is in the region (intervals miss no piece of it). **Not guaranteed:**
//! beside the medial axis, where the feet on two sides are equally far to within the spacing's square over the
//! distance, the answer may be the other one.

mod point_tree;

use std::sync::atomic::AtomicBool;

use glam::DVec3;

pub(crate) use self::point_tree::PointTree;
use super::Foot;
use super::band;
use super::polish::around::{Approach, Around, box_of};
use super::polish::{Resolution, Sides};
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Points, Slope};
use crate::grid::{Lattice, VoxelSize};

/// Answers closest points, in batches, from any thread.
pub trait ClosestPoint: Sync {
    /// The closest surface point to each position. Positions of one call lie near each other. `feet` has the
    /// length of `positions` and is overwritten. A position where the field is not a number gets a distance that
    /// is not one.
    fn feet(&self, positions: &[DVec3], feet: &mut [Foot]);
}

/// How a long computation is watched and stopped.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Set by another thread to stop the work.
    pub cancel: &'a AtomicBool,
    /// Called now and then with the part done, 0 to 1, from any thread; later parts may be told before earlier ones.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

impl Watch<'_> {
    /// Whether the work is to stop.
    pub fn cancelled(&self) -> bool {
        self.cancel.load(std::sync::atomic::Ordering::Relaxed)
    }
}

/// Half the width of the band that seeds are taken from, in spacings: the surface then lies nearer than this to some
/// voxel, even at a corner. Wider gives more seeds than are of use.
const SEED_BAND: f32 = 0.9;

/// Nearer than this to its foot, in spacings, a point takes the field's gradient for its direction: the foot is right
/// to a thousandth, too little to aim with.
const TOO_NEAR: f64 = 0.05;

/// Closest points on the zero set of any field.
pub struct FieldFeet<'a> {
    field: &'a dyn Field,
    outside: bool,
    inside: bool,
    seeds: PointTree,
    spacing: f64,
    resolution: Resolution,
}

impl<'a> FieldFeet<'a> {
    /// Finds seeds about `spacing` apart on the surface, all of which is to lie in the region. A spacing of a voxel
    /// or two: where the surface has detail finer than that, feet may be those of a neighbouring detail.
    pub fn new(field: &'a dyn Field, region: &Aabb, spacing: f64, watch: &Watch) -> Result<Self, band::Error> {
        let (outside, inside) = match field.slope() {
            Slope::Exact { outside, inside } => (outside, inside),
            _ => (false, false),
        };
        let mut points = Vec::new();
        // A field that is exact on both sides needs none, but one without a surface is still to be told.
        if let Some(voxel_size) = VoxelSize::new(spacing).filter(|_| !(outside && inside)) {
            let lattice = Lattice { voxel_size };
            let settings = band::Settings {
                lattice,
                half_width: SEED_BAND,
                region: region.grown(2.0 * spacing),
                feet: band::Feet::Nearest,
                cancel: watch.cancel,
                progress: watch.progress,
            };
            let measured = band::measure(field, &settings, || {
                let mut feet = Points::new(DVec3::ZERO);
                move |block: &band::MeasuredBlock| -> Vec<DVec3> {
                    block.feet_into(&mut feet);
                    (0..feet.len).map(|i| feet.position(i)).collect()
                }
            })?;
            points = measured.visits.concat();
        }
        let resolution = Resolution::new(spacing, region.size().max_element());
        Ok(Self { field, outside, inside, seeds: PointTree::new(points), spacing, resolution })
    }

    /// How many seeds there are.
    pub fn seeds(&self) -> usize {
        self.seeds.len()
    }
}

/// What one call works with.
struct Work<'a> {
    evaluator: Box<dyn Evaluator + 'a>,
    around: Around,
    sides: Sides,
    at: Box<Gradients>,
    queries: Points,
    /// Those that need a seed, their positions and the numbers of their seeds.
    seeking: Vec<usize>,
    seeking_from: Vec<DVec3>,
    nearest: Vec<usize>,
    open: Vec<Approach>,
}

impl ClosestPoint for FieldFeet<'_> {
    fn feet(&self, positions: &[DVec3], feet: &mut [Foot]) {
        let mut work = Work {
            evaluator: self.field.evaluator(),
            around: Around::new(),
            sides: Sides::new(),
            at: Box::default(),
            queries: Points::new(DVec3::ZERO),
            seeking: Vec::new(),
            seeking_from: Vec::new(),
            nearest: Vec::new(),
            open: Vec::new(),
        };
        for (start, chunk) in (0..).step_by(BATCH).zip(positions.chunks(BATCH)) {
            self.start(start, chunk, &mut feet[start..start + chunk.len()], &mut work);
        }
        let Work { evaluator, around, open, .. } = &mut work;
        around.closest(&mut **evaluator, self.resolution, open);
        for open in open {
            self.finish(positions[open.query], open.foot, &mut feet[open.query]);
        }
    }
}

impl FieldFeet<'_> {
    /// Finds what the field itself tells of at most [`BATCH`] positions, of which `start` is the first's number, and
    /// the seeds of those whose feet it does not tell.
    fn start(&self, start: usize, positions: &[DVec3], feet: &mut [Foot], work: &mut Work) {
        let around = box_of(positions.iter().copied());
        work.queries.origin = around.centre();
        work.queries.len = 0;
        for position in positions {
            work.queries.push((*position - around.centre()).as_vec3());
        }
        // Pruning keeps signs, but not distances away from the surface.
        let prune = !(self.outside || self.inside);
        if prune {
            // Signs are settled a step away.
            work.evaluator.enter(&around.grown(0.1 * self.spacing));
        }
        work.evaluator.gradients(&work.queries, &mut work.at);
        if !(self.outside && self.inside) {
            work.sides.settle(&mut *work.evaluator, self.resolution, &work.queries, &mut work.at);
        }
        if prune {
            work.evaluator.leave();
        }
        work.seeking.clear();
        for (query, (position, foot)) in positions.iter().zip(feet.iter_mut()).enumerate() {
            let (value, slope) = (f64::from(work.at.value[query]), work.at.gradient(query).as_dvec3());
            let gradient = slope.normalize_or_zero();
            let exact = if value < 0.0 { self.outside } else { self.inside };
            *foot = Foot { point: *position, distance: value, gradient, part: 0 };
            if value.is_nan() {
                continue;
            }
            if exact && gradient != DVec3::ZERO {
                foot.point = *position - gradient * value;
            } else {
                work.seeking.push(query);
            }
        }
        let Work { seeking, seeking_from, nearest, open, at, .. } = work;
        seeking_from.clear();
        seeking_from.extend(seeking.iter().map(|&query| positions[query]));
        self.seeds.nearest_each(seeking_from, nearest);
        for (&query, &seed) in seeking.iter().zip(nearest.iter()) {
            let inside = at.value[query] >= 0.0;
            open.push(Approach::new(start + query, positions[query], inside, self.seeds.point(seed)));
        }
    }

    fn finish(&self, position: DVec3, point: DVec3, foot: &mut Foot) {
        let sign = if foot.distance < 0.0 { -1.0 } else { 1.0 };
        let away = position - point;
        let length = away.length();
        foot.point = point;
        foot.distance = sign * length;
        if length > TOO_NEAR * self.spacing || foot.gradient == DVec3::ZERO {
            foot.gradient = (away * sign).normalize_or(DVec3::X);
        }
    }
}

#[cfg(test)]
mod tests;
