//! The attributes of shapes that can be asked for, colours and scalars alike, and what was found of them.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::attribute::{Attribute, Colour, LinearRgb, Scalar, Straight};
use crate::morph::Morph;
use crate::node::assets::Assets;
use crate::node::id::Stage;
use crate::node::model::{Model, Shape, ShapeColour, ShapeId, ShapeScalar};
use crate::node::painted::Paint;
use crate::node::source::Given;
use crate::node::spec::Imported;
use crate::text::colour::{GREY, css};
use crate::text::problem::Problem;

/// Which attribute of shapes is asked for.
pub(crate) trait Asked<const N: usize>: Copy {
    /// A shape's own.
    fn source(self, shape: &Shape) -> Option<&Given<N>>;

    /// What a shape has that has none, beside others that have one.
    fn absent(self) -> [f32; N];

    /// What comes with a file.
    fn of_import(self, import: &Imported, voxel: f64) -> Option<Arc<dyn Attribute<N>>>;

    /// That of a morph at a time of it, from those of its two objects.
    fn morphed(self, morph: &Morph, time: f64, objects: [Arc<dyn Attribute<N>>; 2]) -> Arc<dyn Attribute<N>>;

    /// Its own name among those of its kind.
    fn name(&self) -> &str;

    /// What was found of its kind.
    fn known(paints: &mut Paints) -> &mut Known<N>;

    /// What comes from the volume of voxels that a shape has it from at a frame.
    fn of_voxels(
        self,
        assets: &Assets,
        model: &Model,
        id: ShapeId,
        frame: f64,
    ) -> Result<Arc<dyn Attribute<N>>, Problem>;

    /// The problem of copies whose parts have several values.
    fn several(self, shape: &Shape) -> Problem;
}

/// What was found of one kind of attribute, by its name, the shape, how far that is made, and the voxel's edge as bits.
pub(crate) type Known<const N: usize> = BTreeMap<(String, ShapeId, Stage, u64), Option<Paint<N>>>;

/// The attributes found at one moment: a shape that many others are made from is looked at once.
#[derive(Clone, Default)]
pub(crate) struct Paints {
    colours: Known<3>,
    scalars: Known<1>,
}

/// The colour.
#[derive(Clone, Copy)]
pub(crate) struct TheColour;

impl Asked<3> for TheColour {
    fn source(self, shape: &Shape) -> Option<&ShapeColour> {
        shape.colour.as_ref()
    }

    fn absent(self) -> LinearRgb {
        css(GREY).expect("it is a colour")
    }

    fn of_import(self, import: &Imported, voxel: f64) -> Option<Arc<Colour>> {
        import.colours.as_ref().map(|colours| colours(voxel))
    }

    fn morphed(self, morph: &Morph, time: f64, [from, to]: [Arc<Colour>; 2]) -> Arc<Colour> {
        morph.colour_of(time, Some(from), Some(to))
    }

    fn name(&self) -> &str {
        ""
    }

    fn known(paints: &mut Paints) -> &mut Known<3> {
        &mut paints.colours
    }

    fn of_voxels(self, assets: &Assets, model: &Model, id: ShapeId, frame: f64) -> Result<Arc<Colour>, Problem> {
        let colours = assets.colours(model, id, frame)?;
        Ok(colours as Arc<Colour>)
    }

    fn several(self, shape: &Shape) -> Problem {
        Problem::new(shape.span, format!("the copies of `{}` cannot take its parts' several colours", shape.name))
            .help("give it a `color` of its own: one, or { palette = …, by = \"cell\" }")
    }
}

/// The scalar of a name.
#[derive(Clone, Copy)]
pub(crate) struct TheScalar<'n>(pub &'n str);

impl Asked<1> for TheScalar<'_> {
    fn source(self, shape: &Shape) -> Option<&ShapeScalar> {
        shape.scalars.get(self.0)
    }

    fn absent(self) -> [f32; 1] {
        [0.0]
    }

    fn of_import(self, _import: &Imported, _voxel: f64) -> Option<Arc<Scalar>> {
        None
    }

    fn morphed(self, morph: &Morph, time: f64, [from, to]: [Arc<Scalar>; 2]) -> Arc<Scalar> {
        morph.attribute(time, from, to, Straight)
    }

    fn name(&self) -> &str {
        self.0
    }

    fn known(paints: &mut Paints) -> &mut Known<1> {
        &mut paints.scalars
    }

    fn of_voxels(self, assets: &Assets, model: &Model, id: ShapeId, frame: f64) -> Result<Arc<Scalar>, Problem> {
        let scalar = assets.scalar(model, id, self.0, frame)?;
        Ok(scalar as Arc<Scalar>)
    }

    fn several(self, shape: &Shape) -> Problem {
        let Shape { name, span, .. } = shape;
        let problem = format!("the copies of `{name}` cannot take the several values of its parts' `{}`", self.0);
        let help = format!("give it an `attribute.{}` of its own: one, or {{ range = …, by = \"cell\" }}", self.0);
        Problem::new(*span, problem).help(help)
    }
}
