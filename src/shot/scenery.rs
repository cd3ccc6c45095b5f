//! A shape with its attributes.

use std::sync::Arc;

use crate::attribute::{Colour, Scalar};
use crate::field::Field;
use crate::grid::Lattice;
use crate::node::attributes::{TheColour, TheScalar};
use crate::node::id::Stage;
use crate::node::model::ShapeId;
use crate::node::solid::Solids;
use crate::text::problem::Problem;

/// A field with its attributes.
#[derive(Clone)]
pub(crate) struct Scenery {
    /// F, world units.
    pub field: Arc<dyn Field>,
    /// The colour; `None` where there is none.
    pub colour: Option<Arc<Colour>>,
    /// The scalars by the names of their grids, sorted.
    pub scalars: Vec<(String, Arc<Scalar>)>,
}

/// A shape's field and attributes, as far as they are to be written.
pub(crate) fn scenery(solids: &mut Solids, id: ShapeId, lattice: &Lattice) -> Result<Scenery, Problem> {
    let field = solids.field(id, Stage::Placed)?;
    let (model, voxel) = (solids.model(), lattice.voxel_size.get());
    let mut colour = None;
    if model.output.writes(&model.output.colour_name) {
        colour = solids.paint(TheColour, id, Stage::Placed, voxel)?;
    }
    let mut scalars = Vec::new();
    for name in model.scalar_names().into_iter().filter(|name| model.output.writes(name)) {
        if let Some(paint) = solids.paint(TheScalar(name), id, Stage::Placed, voxel)? {
            scalars.push((name.to_owned(), paint.attribute));
        }
    }
    Ok(Scenery { field, colour: colour.map(|paint| paint.attribute), scalars })
}
