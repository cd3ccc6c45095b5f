//! The signed distance in the plane by the closest points themselves, everywhere: what a picture shows of it. What the
//! [`quadtree`](super::quadtree) restores of it is smooth, takes less time, and rounds what is far away and across the medial axis.
//!
//! Guaranteed and not guaranteed is what [`outline`](super::outline) says.

use std::sync::Arc;

use glam::DVec3;

use super::Foot;
use super::nearest::{ClosestPoint, Watch};
use super::octree::BuildError;
use super::outline::{OutlineFeet, Pieces};
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points, Slope};

/// The distance to the outline of a field that does not know z.
pub struct Outlined {
    field: Arc<dyn Field>,
    pieces: Pieces,
}

impl Outlined {
    /// Finds the outline in a region, whose z is of no account, on a lattice of cells of an edge.
    ///
    /// # Errors
    /// Those of [`OutlineFeet::new`].
    pub fn new(field: &Arc<dyn Field>, region: &Aabb, cell: f64, watch: &Watch<'_>) -> Result<Self, BuildError> {
        let pieces = OutlineFeet::new(field.as_ref(), region, cell, watch)?.into_pieces();
        Ok(Self { field: Arc::clone(field), pieces })
    }

    fn feet(&self) -> OutlineFeet<'_> {
        OutlineFeet::of(self.field.as_ref(), &self.pieces)
    }
}

const NOWHERE: Foot = Foot { point: DVec3::ZERO, distance: 0.0, gradient: DVec3::ZERO, part: 0 };

impl Field for Outlined {
    fn bounding_box(&self) -> Option<Aabb> {
        self.field.bounding_box()
    }

    fn slope(&self) -> Slope {
        Slope::Exact { outside: true, inside: true }
    }

    fn reference(&self, position: DVec3) -> f64 {
        let mut foot = [NOWHERE];
        self.feet().feet(&[position], &mut foot);
        foot[0].distance
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(OutlinedEvaluator {
            outlined: self,
            feet: self.feet(),
            found: vec![NOWHERE; BATCH],
            positions: Vec::new(),
            regions: Vec::new(),
        })
    }
}

struct OutlinedEvaluator<'a> {
    outlined: &'a Outlined,
    feet: OutlineFeet<'a>,
    found: Vec<Foot>,
    positions: Vec<DVec3>,
    regions: Vec<Aabb>,
}

impl OutlinedEvaluator<'_> {
    fn find(&mut self, points: &Points) {
        self.positions.clear();
        self.positions.extend((0..points.len).map(|i| points.position(i)));
        self.feet.feet(&self.positions, &mut self.found[..points.len]);
    }
}

impl Evaluator for OutlinedEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.regions.push(*region);
    }

    fn bounds(&mut self) -> Interval {
        let Some(region) = self.regions.last() else { return Interval::ALL };
        let reach = 0.500_01 * region.size().truncate().length();
        let middle = self.outlined.reference(region.centre());
        Interval::new(middle - reach, middle + reach)
    }

    fn hints(&mut self, _: Hint) -> Hints {
        Hints { steepest: Some(1.0), ..Hints::NONE }
    }

    fn leave(&mut self) {
        self.regions.pop();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        self.find(points);
        out.iter_mut().zip(&self.found[..points.len]).for_each(|(out, foot)| *out = foot.distance as f32);
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        self.find(points);
        for (i, foot) in self.found[..points.len].iter().enumerate() {
            out.set(i, (foot.distance, foot.gradient));
        }
    }
}
