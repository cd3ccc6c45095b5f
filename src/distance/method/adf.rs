//! `adf`: an adaptively sampled distance field (Frisken et al. 2000; HFRep, section 4): an octree, in the plane a quadtree, whose
//! corners have the distances and gradients of closest points, restored by C¹ patches, with F's own sign.
//!
//! **Guaranteed:** no jump but on the surface, where it has F's side; its cells are no smaller than a voxel, or than the depth
//! that was chosen says. **Not guaranteed:** between corners it misses by a fiftieth of a smallest cell where the distance is
//! smooth, and by more on what is curved within such a cell and at creases, which a patch rounds. Restored linearly it jumps
//! from cell to cell.

use std::sync::Arc;

use rayon::prelude::*;

use super::closest_point::ClosestPoint;
use super::own_sign::OwnSign;
use super::{AsChosen, Measured, MeasuredInPlane, Method, Request};
use crate::distance::descent::Scope;
use crate::distance::extent::{BandBoxes, Effort};
use crate::distance::nearest::{FieldFeet, Watch};
use crate::distance::octree::refine::LARGEST_AT_SURFACE;
use crate::distance::octree::samples::BYTES_A_SAMPLE;
use crate::distance::octree::{self, BuildError, DistanceObject, Settings};
use crate::field::{Aabb, BATCH, Field, Points};
use crate::grid::{BLOCK_EDGE, Band, Lattice, VoxelSize, mask};

/// The octree of a band: a cell and its corners, of which there are a few for each voxel that the surface passes through.
const BYTES_A_NODE: usize = 16;

/// The method.
pub struct Adf;

impl Method for Adf {
    fn name(&self) -> &'static str {
        "adf"
    }

    fn measure(&self, request: &Request<'_>, watch: &Watch<'_>) -> Result<Measured, BuildError> {
        admit(request.field.as_ref(), &request.settings)?;
        let found = ClosestPoint.measure(request, watch)?;
        Ok(Measured::signed(found.object, request.field))
    }

    fn measure_in_plane(&self, request: &Request<'_>, watch: &Watch<'_>) -> Result<MeasuredInPlane, BuildError> {
        let MeasuredInPlane { distance: magnitude, report } = ClosestPoint.measure_in_plane(request, watch)?;
        let field = Arc::clone(request.field);
        Ok(MeasuredInPlane { distance: Arc::new(OwnSign { magnitude, field }), report })
    }

    fn bytes_a_node(&self) -> usize {
        BYTES_A_NODE
    }

    fn restored(&self, object: Arc<DistanceObject>, field: &Arc<dyn Field>) -> Measured {
        Measured::signed(object, field)
    }

    fn measure_band(
        &self,
        field: &dyn Field,
        band: &mut Band,
        AsChosen { choice, memory_limit }: AsChosen,
        watch: &Watch<'_>,
    ) -> Result<(), BuildError> {
        let (lattice, voxel) = (band.lattice, band.lattice.voxel_size.get());
        let boxes = band.origins.iter().map(|origin| {
            let [first, last] = [*origin, *origin + (BLOCK_EDGE - 1)].map(|voxel| lattice.centre(voxel));
            Aabb::new(first, last)
        });
        let Some(region) = boxes.reduce(Aabb::union) else { return Ok(()) };
        let settings = choice.settings(Settings { memory_limit, ..Settings::new(region, voxel) });
        admit(field, &settings)?;
        let feet = FieldFeet::new(field, &region, voxel, watch)?;
        let object = DistanceObject::build(&feet, &settings, watch)?;
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

/// What a surface takes at least of leaves and samples for each cell at it that is not split for its form: half of what a ball
/// takes, the smoothest of shapes. Greater refuses trees that fit; less lets some grow for minutes that do not.
const LEAVES_A_CELL: f64 = 2.5;
const SAMPLES_A_CELL: f64 = 18.0;

/// Refuses an octree that cannot but take more memory than it may, before it is built: all cells at the surface are split until
/// they are a few smallest ones large, and a surface has about as many of those as voxels of that size to one side. Surfaces at
/// some distance outward have no fewer; of those inward nothing is known.
fn admit(field: &dyn Field, settings: &Settings) -> Result<(), BuildError> {
    if settings.levels.lo > 0.0 {
        return Ok(());
    }
    let cell = f64::from(LARGEST_AT_SURFACE) * settings.smallest_cell;
    let Some(voxel_size) = VoxelSize::new(cell) else { return Ok(()) };
    let scope = Scope { lattice: Lattice { voxel_size }, half_width: 1.0, region: settings.region };
    let cells = 0.5 * BandBoxes::find(field, &scope, Effort::Quick).estimate(&scope).voxels;
    let each = LEAVES_A_CELL * octree::BYTES_A_CELL as f64 + SAMPLES_A_CELL * BYTES_A_SAMPLE as f64;
    let needed = (cells * each) as usize;
    if needed > settings.memory_limit {
        return Err(BuildError::Memory { needed, limit: settings.memory_limit });
    }
    Ok(())
}
