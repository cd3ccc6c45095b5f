//! The box of the shape that something is done to.

use crate::field::Aabb;
use crate::node::spec::Build;
use crate::text::problem::Problem;

/// The box of the shape so far.
pub(crate) fn own_box(build: &mut dyn Build) -> Result<Aabb, Problem> {
    let inner = build.inner()?;
    match build.graph().known_box(inner) {
        Some(own) => Ok(own),
        None => build.solid_box(inner),
    }
}

/// The box of the shape so far, as far as its construction tells it.
pub(crate) fn known_box(build: &mut dyn Build) -> Result<Option<Aabb>, Problem> {
    let inner = build.inner()?;
    Ok(build.graph().known_box(inner))
}
