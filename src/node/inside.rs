//! Insides of shapes are found: their nodes, and what spreads from features in them.

use std::sync::Arc;

use rayon::prelude::*;

use crate::attribute::conformal::{Body, Error, Feature};
use crate::field::{Field, Interval};
use crate::node::extent::{box_of, solid_box};
use crate::node::id::{ShapeId, Stage};
use crate::node::insides::BodyKey;
use crate::node::keeping::Solid;
use crate::node::measured::Purpose;
use crate::node::model::{Model, Shape};
use crate::node::profile::lift_it;
use crate::node::solid::Solids;
use crate::node::source::Inside;
use crate::text::diagnostic::Diagnostic;
use crate::text::problem::Problem;

impl Solids {
    /// The inside of a shape with so many of its modifiers, and shapes as features in it. `key` is what asks for them.
    pub fn inside(
        &mut self,
        (id, step): (ShapeId, usize),
        shapes: &[ShapeId],
        along: u32,
        key: &'static str,
    ) -> Result<Inside, Problem> {
        let body_key = (id, step, along);
        let body = match self.insides.bodies.get(&body_key) {
            Some(known) => Arc::clone(known),
            None => {
                let body = Arc::new(self.body(body_key, key)?);
                self.insides.bodies.insert(body_key, Arc::clone(&body));
                body
            }
        };
        let model = self.model();
        let flat = shapes.iter().map(|shape| model.shape(*shape)).find(|shape| shape.is_flat);
        if let Some(problem) = flat.map(|shape| needs_solid(shape, key)) {
            return Err(problem);
        }
        body.admit(shapes.len()).map_err(|error| problem(&model, body_key, None, &error))?;
        let mut open: Vec<(ShapeId, Arc<dyn Field>)> = Vec::new();
        for shape in shapes {
            let known = self.insides.features.contains_key(&(body_key, *shape));
            if !known && open.iter().all(|(other, _)| other != shape) {
                open.push((*shape, self.feature_distance(&body, *shape, key)?));
            }
        }
        let cancel = Arc::clone(self.cancel());
        let spread = |(shape, field): (ShapeId, Arc<dyn Field>)| (shape, Feature::new(&body, field, &cancel));
        let found: Vec<_> = open.into_par_iter().map(spread).collect();
        for (shape, feature) in found {
            let feature = feature.map_err(|error| problem(&model, body_key, Some(shape), &error))?;
            let warnings = warnings(&model, id, shape, &feature);
            self.insides.warnings.extend(warnings);
            self.insides.features.insert((body_key, shape), Arc::new(feature));
        }
        let features = shapes.iter().map(|shape| Arc::clone(&self.insides.features[&(body_key, *shape)]));
        Ok((body, features.collect()))
    }

    fn body(&mut self, body_key: BodyKey, key: &'static str) -> Result<Body, Problem> {
        let (model, (id, step, along)) = (self.model(), body_key);
        if model.shape(id).is_flat {
            return Err(needs_solid(model.shape(id), key));
        }
        let solid = solid_box(&model, id, self.step_field(id, step)?.as_ref())?;
        let size = solid.size();
        let shape = model.shape(id);
        // Measured as finely as the lattice is: the same whatever is baked how finely.
        let voxel = Some(size.max_element() / f64::from(along));
        let levels = Interval::new(-size.length(), size.length());
        let distance = self.step_distance(
            (id, step),
            levels,
            &Purpose { solid: Solid::Step(id, step), shape, key, span: shape.span, voxel, method: shape.distance },
        )?;
        let body = Body::new(Arc::new(distance), solid, along, self.cancel());
        body.map_err(|error| problem(&model, body_key, None, &error))
    }

    /// The distance to a feature, as far away as the body reaches.
    fn feature_distance(&mut self, body: &Body, id: ShapeId, key: &'static str) -> Result<Arc<dyn Field>, Problem> {
        let model = self.model();
        let shape = model.shape(id);
        let all = match box_of(&self.values(id)?) {
            Ok(feature) => feature.union(body.aabb()),
            // What is endless is said where its distance has to be measured.
            Err(_) => body.aabb(),
        };
        let levels = Interval::new(-all.size().length(), 0.0);
        let (solid, voxel) = (Solid::Stage(id, Stage::Placed), Some(body.edge()));
        let purpose = Purpose { solid, shape, key, span: shape.span, voxel, method: shape.distance };
        Ok(Arc::new(self.distance_values(id, levels, &purpose)?))
    }
}

fn needs_solid(shape: &Shape, key: &str) -> Problem {
    Problem::new(shape.span, format!("`{key}` needs solids, and `{}` is a shape of the plane", shape.name))
        .help(lift_it())
}

/// Why an inside or a feature in it cannot be had.
fn problem(model: &Model, (id, _, along): BodyKey, feature: Option<ShapeId>, error: &Error) -> Problem {
    let shape = model.shape(id);
    match error {
        // Whoever stopped it knows.
        Error::Cancelled => Problem::new(shape.span, "stopped"),
        Error::TooMany { nodes, most } => {
            let problem = format!("the inside of `{}` takes about {nodes} cells, and {most} are the most", shape.name);
            let fewer = (f64::from(along) * (*most as f64 / *nodes as f64).cbrt()).floor();
            Problem::new(shape.span, problem).help(format!("a `lattice` of {fewer} or less"))
        }
        Error::Empty => Problem::new(shape.span, format!("nothing is inside `{}`", shape.name))
            .help("F is negative everywhere: check the signs (positive is inside), the sizes and the bounds"),
        Error::NotANumber(at) => {
            let feature = feature.map_or(shape, |feature| model.shape(feature));
            let problem = format!("F of `{}` is not a number at ({:.4}, {:.4}, {:.4})", feature.name, at.x, at.y, at.z);
            Problem::new(feature.span, problem)
                .help("keep its formulas from dividing by 0, and from roots and logarithms of negative numbers")
        }
    }
}

/// What is worth saying about a feature.
fn warnings(model: &Model, body: ShapeId, feature: ShapeId, found: &Feature) -> Vec<Diagnostic> {
    let (body, feature) = (&model.shape(body).name, model.shape(feature));
    let mut warnings = Vec::new();
    if found.is_outside {
        let problem = format!("all of `{}` is outside of `{body}`", feature.name);
        let help = format!(
            "its ways go straight through the air to the surface first; features stand in the own space of `{body}`, \
             before its scale, rotate and move"
        );
        warnings.push(Diagnostic::warning(feature.span, problem).help(help));
    }
    if let Some(first) = found.apart.first() {
        let count = match found.apart.len() {
            1 => "a piece".to_owned(),
            count => format!("{count} pieces"),
        };
        let at = first.at;
        let problem = format!(
            "no way inside of `{body}` leads from `{}` to {count} of it, the largest around ({:.4}, {:.4}, {:.4})",
            feature.name, at.x, at.y, at.z
        );
        let help = "ways there go through the air from the nearest surface; join the pieces, or give each a feature";
        warnings.push(Diagnostic::warning(feature.span, problem).help(help));
    }
    warnings
}
