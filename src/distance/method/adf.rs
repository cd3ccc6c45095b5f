//! `adf`: an adaptively sampled distance field (Frisken et al. 2000; HFRep, section 4): an octree whose corners have the
//! distances and gradients of closest points, restored by C¹ tricubic patches, with F's own sign.
//!
//! **Guaranteed:** no jump but on the surface, where it has F's side; its cells are no smaller than a voxel. **Not guaranteed:**
//! between corners it misses by a fiftieth of a voxel where the distance is smooth, and by more on what is curved within a
//! voxel and at creases, which a patch rounds.

use std::sync::Arc;

use rayon::prelude::*;

use super::closest_point::ClosestPoint;
use super::{Measured, Method, Request};
use crate::distance::nearest::{FieldFeet, Watch};
use crate::distance::octree::{BuildError, DistanceObject, Settings};
use crate::field::{Aabb, BATCH, Field, Points};
use crate::grid::{BLOCK_EDGE, Band, mask};

/// The octree of a band: a cell and its corners, of which there are a few for each voxel that the surface passes through.
const BYTES_A_NODE: usize = 16;

/// The method.
pub struct Adf;

impl Method for Adf {
    fn name(&self) -> &'static str {
        "adf"
    }

    fn measure(&self, request: &Request<'_>, watch: &Watch<'_>) -> Result<Measured, BuildError> {
        let found = ClosestPoint.measure(request, watch)?;
        Ok(Measured::signed(found.object, request.field))
    }

    fn bytes_a_node(&self) -> usize {
        BYTES_A_NODE
    }

    fn restored(&self, object: Arc<DistanceObject>, field: &Arc<dyn Field>) -> Measured {
        Measured::signed(object, field)
    }

    fn measure_band(&self, field: &dyn Field, band: &mut Band, watch: &Watch<'_>) -> Result<(), BuildError> {
        let (lattice, voxel) = (band.lattice, band.lattice.voxel_size.get());
        let boxes = band.origins.iter().map(|origin| {
            let [first, last] = [*origin, *origin + (BLOCK_EDGE - 1)].map(|voxel| lattice.centre(voxel));
            Aabb::new(first, last)
        });
        let Some(region) = boxes.reduce(Aabb::union) else { return Ok(()) };
        let feet = FieldFeet::new(field, &region, voxel, watch)?;
        let object = DistanceObject::build(&feet, &Settings::new(region, voxel), watch)?;
        // An active voxel is nearer than the background, whatever is restored.
        let most = band.background().next_down();
        let Band { origins, distances, active, .. } = band;
        distances.par_iter_mut().zip(origins).zip(active).for_each_init(
            || (object.evaluator(), Box::new([0.0; BATCH])),
            |(evaluator, values), ((distances, origin), active)| {
                evaluator.values(&Points::of_block(*origin, &lattice), values);
                for place in mask::places(active) {
                    let own = distances[place];
                    let magnitude = if own.is_sign_negative() { -values[place] } else { values[place] };
                    // 0 has no side.
                    distances[place] = magnitude.clamp(f32::MIN_POSITIVE, most).copysign(own);
                }
            },
        );
        Ok(())
    }
}
