//! The box of a shape: where F ≥ 0.

use crate::distance::extent::{self, extent};
use crate::field::{Aabb, Field};
use crate::node::model::{Model, ShapeId};
use crate::node::spec::Carries;
use crate::text::problem::Problem;

/// What finds the box of a shape: [`box_of`] or [`box_about`].
pub(crate) type FindBox = fn(&dyn Field) -> Result<Aabb, extent::Error>;

/// The box of F ≥ 0.
pub(crate) fn box_of(field: &dyn Field) -> Result<Aabb, extent::Error> {
    let solid = extent(field, None)?.solid;
    if solid.size().max_element() > 0.0 { Ok(solid) } else { Err(extent::Error::Empty) }
}

/// A box that holds it, found in a fraction of the time.
pub(crate) fn box_about(field: &dyn Field) -> Result<Aabb, extent::Error> {
    let solid = extent::about(field, None)?.solid;
    if solid.size().max_element() > 0.0 { Ok(solid) } else { Err(extent::Error::Empty) }
}

/// The box of F ≥ 0, or what is wrong with the shape.
pub(crate) fn solid_box(model: &Model, id: ShapeId, field: &dyn Field) -> Result<Aabb, Problem> {
    box_of(field).map_err(|error| no_box(model, id, error))
}

/// What is wrong with a shape that has no box.
pub(crate) fn no_box(model: &Model, id: ShapeId, error: extent::Error) -> Problem {
    let shape = model.shape(id);
    match error {
        extent::Error::Unbounded => {
            let culprit = model.unbounded_part(id);
            let problem = format!("`{}` may reach to infinity", model.shape(culprit).name);
            Problem::new(model.shape(culprit).span, problem)
                .help("give it `bounds`, or intersect it with a shape that ends")
        }
        extent::Error::Empty => Problem::new(shape.span, format!("nothing is inside `{}`", shape.name))
            .help("F is negative everywhere: check the signs (positive is inside), the sizes and the bounds"),
        extent::Error::TooFar => Problem::new(shape.span, format!("`{}`: {error}", shape.name)),
    }
}

impl Model {
    /// The innermost part that makes a shape endless, as far as the parts tell by themselves.
    fn unbounded_part(&self, id: ShapeId) -> ShapeId {
        let mut at = id;
        while self.shape(at).spec.carries == Carries::Union {
            let parts = self.shape(at).painters();
            let uncut = |part: &&ShapeId| self.shape(**part).bounds().is_none();
            let endless = parts.iter().filter(uncut).find(|part| self.shape(**part).spec.is_endless);
            let is_union = |part: &&ShapeId| self.shape(**part).spec.carries == Carries::Union;
            let next = endless.or_else(|| parts.iter().filter(uncut).find(is_union)).copied();
            match next {
                Some(part) => at = part,
                None => break,
            }
        }
        at
    }
}
