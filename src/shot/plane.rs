//! Morphs of shapes of the plane: what is measured of them there, and how far they are extruded.

use std::sync::Arc;

use crate::field::{Aabb, Expression, Field, Graph};
use crate::morph::{Motion, Plane};
use crate::text::frames::sampled_frames;
use crate::text::problem::Problem;

use crate::node::id::Stage;
use crate::node::model::{Model, Morph, ShapeId};
use crate::node::solid::Solids;
use crate::shot::placed::{leaves, scale_is_uniform, stands, whole};

/// How high the longer side of the longest shape is.
const SHARE: f64 = 1.0 / 8.0;

/// How far the morphs of a chain are extruded, in their own units: as the scene says, or an eighth of the longest side of its
/// shapes, as large as they get. `None` of solids.
pub(crate) fn height(model: &Model, solids: &mut Solids, morphs: &[Morph]) -> Result<Option<f64>, Problem> {
    if !morphs[0].in_plane {
        return Ok(None);
    }
    if morphs[0].height.is_some() {
        return Ok(morphs[0].height);
    }
    let mut longest: f64 = 0.0;
    for id in morphs.iter().flat_map(|morph| [morph.from, morph.to]) {
        let shape = model.shape(id);
        let stage = if scale_is_uniform(model, shape)? { Stage::Own } else { Stage::Scaled };
        let (_, aabb) = profile(model, solids, id, stage)?;
        for frame in sampled_frames(model.shot.range) {
            let scale = if stage == Stage::Own { shape.placement.scale[0].at(&model.moment(frame))? } else { 1.0 };
            longest = longest.max(scale * aabb.longest_side());
        }
    }
    Ok(Some(SHARE * longest))
}

/// A shape of the plane in its own space, and its box there, of no height.
pub(crate) fn profile(
    model: &Model,
    solids: &mut Solids,
    id: ShapeId,
    stage: Stage,
) -> Result<(Arc<dyn Field>, Aabb), Problem> {
    solids.in_plane(id, stage)?.ok_or_else(|| leaves(model.shape(id)))
}

/// The box of what is extruded so far in the world, in the space of a shape of the plane that is nowhere smaller there.
pub(crate) fn thick(profile: Aabb, height: f64, motion: &Motion, model: &Model) -> Aabb {
    let range = model.shot.range;
    let scales = sampled_frames(range).into_iter().map(|frame| motion.at(range.share(frame)).scale());
    let half = 0.5 * height / scales.fold(f64::INFINITY, f64::min);
    Aabb::new(profile.min.with_z(-half), profile.max.with_z(half))
}

/// What is extruded of a shape of the plane in that box.
pub(crate) fn extruded(profile: &Arc<dyn Field>, solid: Aabb) -> Arc<dyn Field> {
    let mut graph = Graph::new();
    let (profile, caps) = (graph.field(Arc::clone(profile)), graph.slab(glam::DVec3::Z, solid.size().z));
    let node = graph.corner(profile, caps);
    let node = graph.bounded(node, solid);
    Arc::new(Expression::new(&graph, node))
}

/// The plane of a morph that is extruded so far.
pub(crate) fn plane(model: &Model, morph: &Morph, height: f64) -> Result<Plane, Problem> {
    let start = model.moment(morph.over.first as f64);
    Ok(Plane::new(height, &stands(&whole(morph), true, &start)?))
}
