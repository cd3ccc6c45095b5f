//! The attributes of a morph's frames: of the two objects as wholes, or part by part where parts correspond.

use std::sync::Arc;

use crate::attribute::{Attribute, Colour, Constant, Part, Parts, Rule, Scalar, Straight};
use crate::field::{Expression, Field, Graph};

use crate::node::attributes::{Asked, TheColour, TheScalar};
use crate::node::model::{Content, Correspondence, Master};
use crate::node::painted::Paint;
use crate::node::source::TOLERANCE_VOXELS;
use crate::shot::morphing::{Brush, Planned};
use crate::shot::prepared::Prepared;
use crate::text::problem::Problem;

/// A frame's colour, `None` where there is none, and its scalars by the names of their grids, sorted.
type Attributes = (Option<Arc<Colour>>, Vec<(String, Arc<Scalar>)>);

impl Prepared {
    /// The attributes of a morph's frame, as far as they are to be written.
    pub(crate) fn morph_attributes(&self, planned: &Planned, frame: f64) -> Result<Attributes, Problem> {
        let of_one = |planned| Ok((self.morph_colour(planned, frame)?, self.morph_scalars(planned, frame)?));
        let Some(correspondence) = self.correspondence(frame) else { return of_one(planned) };
        let of_parts: Vec<Attributes> = planned.parts.iter().map(of_one).collect::<Result<_, Problem>>()?;
        // All have the same grids.
        let (colour, scalars) = &of_parts[0];
        if colour.is_none() && scalars.is_empty() {
            return Ok((None, Vec::new()));
        }
        let fields = self.fields_of_parts(planned, frame);
        let colours: Option<Vec<Arc<Colour>>> = of_parts.iter().map(|(colour, _)| colour.clone()).collect();
        let rest = match correspondence.master {
            Some(Master::Colour(colour)) => Some(Arc::new(Constant::new(colour)) as Arc<Colour>),
            _ => None,
        };
        let colour = colours.map(|colours| self.joined(&fields, colours, correspondence, rest.clone()));
        let scalar = |(place, (name, _)): (usize, &(String, Arc<Scalar>))| {
            let scalars = of_parts.iter().map(|(_, scalars)| Arc::clone(&scalars[place].1)).collect();
            (name.clone(), self.joined(&fields, scalars, correspondence, None))
        };
        Ok((colour, scalars.iter().enumerate().map(scalar).collect()))
    }

    fn correspondence(&self, frame: f64) -> Option<&Correspondence> {
        let Content::Morph(morphs) = &self.model.content else { return None };
        morphs[self.shown(frame)].correspondence.as_ref()
    }

    /// Each part's attribute where the part is, and where none is that of the rest, if it has one of its own.
    fn joined<const N: usize>(
        &self,
        fields: &[Arc<dyn Field>],
        attributes: Vec<Arc<dyn Attribute<N>>>,
        correspondence: &Correspondence,
        rest: Option<Arc<dyn Attribute<N>>>,
    ) -> Arc<dyn Attribute<N>> {
        let mut parts: Vec<Part<N>> = fields.iter().cloned().zip(attributes).collect();
        let master = match (correspondence.master, rest) {
            (Some(Master::Pair(place)), _) => Some(place),
            (_, Some(rest)) => {
                parts.push((nowhere(), rest));
                Some(parts.len() - 1)
            }
            _ => None,
        };
        let rule = Rule::Partitions { overlap: correspondence.overlap, master };
        let tolerance = TOLERANCE_VOXELS * self.lattice.voxel_size.get();
        Arc::new(Parts::new(parts, rule, tolerance).expect("there is a pair"))
    }

    /// A morph's colour; `None` where nothing in it has one. Colours that change over time are made for the frame.
    fn morph_colour(&self, planned: &Planned, frame: f64) -> Result<Option<Arc<Colour>>, Problem> {
        if !planned.has_colour || !self.model.output.writes(&self.model.output.colour_name) {
            return Ok(None);
        }
        let now =
            |brush: &Brush| self.repainted(TheColour, brush, frame).map(|paint| paint.map(|paint| paint.attribute));
        Ok(Some(planned.morph.colour_of(self.model.shot.range.share(frame), now(&planned.from)?, now(&planned.to)?)))
    }

    /// A morph's scalars, mixed by the weights of colours.
    fn morph_scalars(&self, planned: &Planned, frame: f64) -> Result<Vec<(String, Arc<Scalar>)>, Problem> {
        let written = planned.scalars.iter().filter(|(name, _)| self.model.output.writes(name));
        written.map(|(name, known)| Ok((name.clone(), self.mixed_scalar(planned, name, known, frame)?))).collect()
    }

    fn mixed_scalar(
        &self,
        planned: &Planned,
        name: &str,
        known: &[Arc<Scalar>; 2],
        frame: f64,
    ) -> Result<Arc<Scalar>, Problem> {
        let now = |brush: &Brush, known: &Arc<Scalar>| -> Result<Arc<Scalar>, Problem> {
            let now = self.repainted(TheScalar(name), brush, frame)?;
            Ok(now.map_or_else(|| Arc::clone(known), |paint| paint.attribute))
        };
        let (from, to) = (now(&planned.from, &known[0])?, now(&planned.to, &known[1])?);
        Ok(planned.morph.attribute(self.model.shot.range.share(frame), from, to, Straight))
    }

    /// One scalar of a morph's frame, whether it is written or not; `None` where no object has it.
    pub(crate) fn morph_scalar(
        &self,
        planned: &Planned,
        name: &str,
        frame: f64,
    ) -> Result<Option<Arc<Scalar>>, Problem> {
        let of_one = |planned: &Planned| -> Result<Option<Arc<Scalar>>, Problem> {
            let Some((_, known)) = planned.scalars.iter().find(|(there, _)| there == name) else { return Ok(None) };
            Ok(Some(self.mixed_scalar(planned, name, known, frame)?))
        };
        let Some(correspondence) = self.correspondence(frame) else { return of_one(planned) };
        let scalars: Option<Vec<_>> = planned.parts.iter().map(of_one).collect::<Result<_, Problem>>()?;
        Ok(scalars.map(|scalars| self.joined(&self.fields_of_parts(planned, frame), scalars, correspondence, None)))
    }

    fn fields_of_parts(&self, planned: &Planned, frame: f64) -> Vec<Arc<dyn Field>> {
        let time = self.model.shot.range.share(frame);
        // On what caps all that is extruded, all parts' fields are alike.
        planned.parts.iter().map(|part| part.morph.profile(time)).collect()
    }

    /// An attribute of a morph's object as it is in a frame; `None` where it does not change over time.
    fn repainted<const N: usize>(
        &self,
        what: impl Asked<N>,
        brush: &Brush,
        frame: f64,
    ) -> Result<Option<Paint<N>>, Problem> {
        if !self.variation.painted(brush.id) {
            return Ok(None);
        }
        let mut solids = self.base.at(self.model.moment(frame), &self.variation);
        solids.paint(what, brush.id, brush.stage, brush.voxel)
    }
}

/// A field without a solid.
fn nowhere() -> Arc<dyn Field> {
    let mut graph = Graph::new();
    let outside = graph.constant(-1.0);
    Arc::new(Expression::new(&graph, outside))
}
