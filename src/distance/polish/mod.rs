//! Closest surface points for a batch of positions, found on the true F.
//!
//! A closest point q of p satisfies F(q) = 0 with p − q along ∇F(q). Where the surface is smooth that is a
//! constrained Newton iteration ([`smooth`]). Where smooth pieces meet, the closest point may lie on the crease
//! between two of them or in a corner of three, where F has no gradient to follow; candidates are then sought on
//! each branch alone, on each pair and on each triple of branches, and the nearest that lies on F = 0, and behind
//! which the solid ends ([`wall`]), wins ([`crease`]).
//!
//! Guaranteed: a result lies on F = 0 within about 0.01 unit, and is no farther than a seed on the surface that the
//! caller gave. Not guaranteed: that it is the *global* closest point; give seeds (a neighbour's foot) for that.

pub mod around;
mod crease;
mod first_step;
mod kernel;
mod lanes;
mod rows;
mod sides;
mod smooth;
mod wall;

use crate::field::{Aabb, BATCH, Evaluator, Gradients, Points};

pub use crease::{COMBINED, FEW};
pub use kernel::within;
use lanes::Lanes;
pub use sides::{Resolution, Sides};

/// A query whose |F|/|∇F| is more than this many reaches is not followed to the surface. Smaller relies on feet offered
/// by neighbours inside small balls written as r² − |p|², where the quotient overestimates; larger wastes evaluations.
const FAR: f32 = 2.0;

/// The same where |∇F| is the steepest of a block's voxels. F is hardly steeper on the way from them to their feet, so
/// that what is put farther is out of reach.
const OUT_OF_REACH: f32 = 1.3;

/// What a batch of closest points is sought for. The evaluator must have entered a region that holds `region`.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    /// Results are right to about a hundredth of this length, world units; for a band, the voxel size.
    pub unit: f32,
    /// The least thickness of sheets and gaps that are told from none, world units: see [`Resolution`].
    pub least: f32,
    /// Feet farther than this from their query do not matter and may not be found, world units.
    pub reach: f32,
    /// F is never evaluated outside of this box; holds all queries and seeds.
    pub region: Aabb,
}

impl Request {
    fn resolution(&self) -> Resolution {
        Resolution { unit: self.unit, least: self.least }
    }
}

/// Scratch memory of one thread for [`Polisher::closest`]. Large: keep it, do not make one a call.
pub struct Polisher {
    lanes: Box<Lanes>,
    gradients: Box<Gradients>,
    crease: crease::Scratch,
}

impl Polisher {
    /// Allocates the scratch memory.
    pub fn new() -> Self {
        Self { lanes: Box::default(), gradients: Box::default(), crease: crease::Scratch::default() }
    }

    /// Like [`Polisher::closest`] for the voxels of a block, where none has a seed and F is known. Those that F and its
    /// gradients put well out of reach are passed over.
    pub fn closest_from(
        &mut self,
        evaluator: &mut dyn Evaluator,
        request: &Request,
        queries: &Points,
        at_queries: &Gradients,
        feet: &mut Box<Points>,
        distances: &mut Box<[f32; BATCH]>,
    ) {
        if evaluator.branches() > 1 {
            (feet.origin, feet.len) = (queries.origin, queries.len);
            let inside = std::array::from_fn(|i| at_queries.value[i] >= 0.0);
            self.forget_seeds(distances);
            self.crease_closest(evaluator, request, queries, &inside, feet, distances);
            return;
        }
        let Self { lanes, gradients, .. } = self;
        let near = kernel::near_in_block(at_queries, FAR * request.reach, OUT_OF_REACH * request.reach);
        let evaluate = |points: &Points, out: &mut Gradients| evaluator.gradients(points, out);
        lanes.solve_known(request, queries, at_queries, &near, gradients, evaluate);
        // The results change hands, nothing is copied.
        std::mem::swap(distances, &mut lanes.distance);
        std::mem::swap(feet, &mut lanes.foot);
        (feet.origin, feet.len) = (queries.origin, queries.len);
    }

    /// Finds the closest surface point of each query; `inside` tells where F ≥ 0.
    ///
    /// `feet` holds the starting points (same `len` and `origin` as `queries`): a seed on the surface, or the query
    /// itself where none is known. On return it holds the closest points, and `distances` the unsigned distances to
    /// them, world units; infinity (and an unspecified foot) where none was found.
    pub fn closest(
        &mut self,
        evaluator: &mut dyn Evaluator,
        request: &Request,
        queries: &Points,
        inside: &[bool; BATCH],
        feet: &mut Points,
        distances: &mut [f32; BATCH],
    ) {
        debug_assert_eq!((queries.len, queries.origin), (feet.len, feet.origin));
        if evaluator.branches() > 1 {
            self.take_seeds(evaluator, request, queries, feet, distances);
            self.crease_closest(evaluator, request, queries, inside, feet, distances);
        } else {
            self.lanes.load(request, queries, feet, 0..queries.len);
            self.lanes.solve(request, &mut self.gradients, |points, out| evaluator.gradients(points, out));
            distances[..queries.len].fill(f32::INFINITY);
            self.lanes.store(feet, distances);
        }
    }
}

impl Default for Polisher {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;
