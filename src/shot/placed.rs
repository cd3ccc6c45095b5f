//! Where the shapes of a morph stand over scene time.

use std::sync::Arc;

use glam::DVec3;

use crate::morph::{Motion, Similarity};
use crate::node::model::{Model, Morph, Placement, Shape, ShapeId};
use crate::node::profile::{leaves_the_plane, lift_it};
use crate::text::frames::sampled_frames;
use crate::text::moment::Moment;
use crate::text::number::Number;
use crate::text::problem::Problem;
use crate::text::source::Span;

/// Whether a shape is scaled alike along x, y and z; the problem where it is not, and that changes.
pub(crate) fn scale_is_uniform(model: &Model, shape: &Shape) -> Result<bool, Problem> {
    let scale = &shape.placement.scale;
    for frame in sampled_frames(model.shot.range) {
        let moment = model.moment(frame);
        let [x, y, z] = [scale[0].at(&moment)?, scale[1].at(&moment)?, scale[2].at(&moment)?];
        if x != y || x != z {
            if scale.iter().any(|number| model.varies(number)) {
                let problem = format!("`{}` is stretched over time, and so cannot enter a morph", shape.name);
                return Err(Problem::new(scale[0].span, problem).help("scale it by one number, alike along x, y and z"));
            }
            return Ok(false);
        }
    }
    Ok(true)
}

/// Where a shape of a morph stands over scene time.
pub(crate) fn motion(
    model: &Arc<Model>,
    id: ShapeId,
    scaled: bool,
    morph: &Morph,
    moves: bool,
) -> Result<Motion, Problem> {
    let shape = model.shape(id);
    let own: Placed = (shape.placement.clone(), shape.span, format!("`{}`", shape.name));
    let (whole, in_plane) = (whole(morph), morph.in_plane);
    let moves = moves || model.placement_varies(&morph.placement);
    let of = Arc::clone(model);
    let placement = move |moment: &Moment| -> Result<Similarity, Problem> {
        let mut own = stands(&own, scaled, moment)?;
        if in_plane {
            own = own.in_plane().ok_or_else(|| leaves(of.shape(id)))?;
        }
        Ok(own.moved(&stands(&whole, true, moment)?))
    };
    let range = model.shot.range;
    if !moves {
        return Ok(Motion::still(placement(&model.moment(range.first as f64))?));
    }
    // Every frame is tried now, so that errors come with their place; what lies between is held to the frames.
    let placements: Vec<Similarity> = sampled_frames(model.shot.range)
        .iter()
        .map(|frame| placement(&model.moment(*frame)))
        .collect::<Result<_, _>>()?;
    let model = Arc::clone(model);
    Ok(Motion::moving(move |time| {
        let moment = model.moment(model.shot.frame_at(time));
        placement(&moment).unwrap_or_else(|_| {
            let nearest = (time.clamp(0.0, 1.0) * (placements.len() - 1) as f64).round() as usize;
            placements[nearest]
        })
    }))
}

/// A placement, where the scene has what it places, and what that is called.
type Placed = (Placement, Span, String);

/// The placement of a morph as a whole.
pub(crate) fn whole(morph: &Morph) -> Placed {
    (morph.placement.clone(), morph.span, "the morph".to_owned())
}

/// Where a placement puts what it is of; `scaled`: its scale is one number, and counts.
pub(crate) fn stands((placement, span, what): &Placed, scaled: bool, moment: &Moment) -> Result<Similarity, Problem> {
    let vector = |numbers: &[Number; 3]| -> Result<DVec3, Problem> {
        Ok(DVec3::new(numbers[0].at(moment)?, numbers[1].at(moment)?, numbers[2].at(moment)?))
    };
    let scale = if scaled { placement.scale[0].at(moment)? } else { 1.0 };
    Similarity::new(scale, vector(&placement.rotate)?, vector(&placement.translate)?)
        .ok_or_else(|| Problem::new(*span, format!("{what} cannot be placed: a number is out of range")))
}

/// What is wrong with a morph whose shape of the plane leaves it.
pub(crate) fn leaves(shape: &Shape) -> Problem {
    let help = format!("turn it about z alone, or {} first; `morph.rotate` turns the whole", lift_it());
    leaves_the_plane(shape).help(help)
}
