//! `closest-point`: distances are the lengths of the ways to closest points on the zero set, and a spline over an octree of
//! them, in the plane over a quadtree, answers everywhere. What holds of these is told in
//! [`nearest`](crate::distance::nearest), [`octree`](crate::distance::octree) and [`quadtree`](crate::distance::quadtree).

use std::sync::Arc;

use super::{Measured, MeasuredInPlane, Method, Request};
use crate::distance::nearest::{FieldFeet, Watch};
use crate::distance::octree::{BuildError, DistanceObject};
use crate::distance::outline::OutlineFeet;
use crate::distance::quadtree::Quadtree;

/// The share that finding seeds has in the time that measuring takes.
const SEEDING: f64 = 0.1;

/// The method of closest points.
pub struct ClosestPoint;

impl Method for ClosestPoint {
    fn name(&self) -> &'static str {
        "closest-point"
    }

    fn measure(&self, request: &Request<'_>, watch: &Watch<'_>) -> Result<Measured, BuildError> {
        let Request { field, solid, detail, settings } = request;
        let Watch { cancel, progress } = *watch;
        let seeding = |part: f64| progress(SEEDING * part);
        let feet = FieldFeet::new(field.as_ref(), solid, *detail, &Watch { cancel, progress: &seeding })?;
        let building = |part: f64| progress(SEEDING + (1.0 - SEEDING) * part);
        let object = DistanceObject::build(&feet, settings, &Watch { cancel, progress: &building })?;
        Ok(Measured::of(Arc::new(object)))
    }

    fn measure_in_plane(&self, request: &Request<'_>, watch: &Watch<'_>) -> Result<MeasuredInPlane, BuildError> {
        let Request { field, solid, settings, .. } = request;
        let feet = OutlineFeet::new(field.as_ref(), solid, settings.smallest_cell, watch)?;
        let tree = Quadtree::build(&feet, *solid, settings, watch)?;
        Ok(MeasuredInPlane { report: *tree.report(), distance: Arc::new(tree) })
    }
}
