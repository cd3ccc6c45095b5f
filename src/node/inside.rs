//! Insides of shapes are found: their nodes, and what spreads from features in them.

use std::sync::Arc;

use rayon::prelude::*;

use crate::attribute::conformal::{Body, Error, Feature, Leak, Method};
use crate::field::{Expression, Field, Graph, Interval};
use crate::node::conformal::MOST_ALONG;
use crate::node::extent::{box_of, solid_box};
use crate::node::id::{ShapeId, Stage};
use crate::node::insides::{BodyKey, MethodKey};
use crate::node::keeping::Solid;
use crate::node::measured::Purpose;
use crate::node::model::{Model, Shape};
use crate::node::profile::lift_it;
use crate::node::solid::Solids;
use crate::node::source::{Inside, InsideRequest};
use crate::text::diagnostic::Diagnostic;
use crate::text::problem::Problem;
use crate::text::source::Span;

impl Solids {
    /// The inside of a shape with so many of its modifiers, and what spreads from features in it.
    pub fn inside(&mut self, (id, step): (ShapeId, usize), asked: &InsideRequest<'_>) -> Result<Inside, Problem> {
        let InsideRequest { features, along, ref method, speed, key } = *asked;
        let body_key = (id, step, along);
        let model = self.model();
        let body = match self.insides.bodies.get(&body_key) {
            Some(known) => Arc::clone(known),
            None => {
                let body = Arc::new(self.body(body_key, key)?);
                self.insides.bodies.insert(body_key, Arc::clone(&body));
                body
            }
        };
        let flat = features.iter().flatten().map(|shape| model.shape(*shape)).find(|shape| shape.is_flat);
        if let Some(problem) = flat.map(|shape| needs_solid(shape, key)) {
            return Err(problem);
        }
        body.admit(features.len()).map_err(|error| problem(&model, body_key, None, None, &error))?;
        let method_key = match method {
            Method::Sight => MethodKey::Sight,
            Method::Eikonal { .. } => MethodKey::Eikonal(speed.map(|span| (span.source, span.start))),
        };
        let key_of = |feature: Option<ShapeId>| (body_key, feature, method_key);
        let mut open: Vec<(Option<ShapeId>, Arc<dyn Field>)> = Vec::new();
        for feature in features {
            let known = self.insides.features.contains_key(&key_of(*feature));
            if !known && open.iter().all(|(other, _)| other != feature) {
                let distance = match feature {
                    Some(shape) => self.feature_distance(&body, *shape, key)?,
                    None => beyond(&body),
                };
                open.push((*feature, distance));
            }
        }
        let cancel = Arc::clone(self.cancel());
        let spread = |(feature, field)| (feature, Feature::new(&body, field, method, &cancel));
        let found: Vec<_> = open.into_par_iter().map(spread).collect();
        let is_new = !found.is_empty();
        for (feature, spread) in found {
            let spread = spread.map_err(|error| problem(&model, body_key, feature, speed, &error))?;
            let warnings = feature.map(|feature| warnings(&model, id, feature, &spread));
            self.insides.warnings.extend(warnings.into_iter().flatten());
            self.insides.features.insert(key_of(feature), Arc::new(spread));
        }
        let found: Vec<Arc<Feature>> =
            features.iter().map(|feature| Arc::clone(&self.insides.features[&key_of(*feature)])).collect();
        if is_new && key == "conformal" {
            self.insides.warnings.extend(same_place(&model, features, &found));
        }
        Ok((body, found))
    }

    fn body(&mut self, body_key: BodyKey, key: &'static str) -> Result<Body, Problem> {
        let (model, (id, step, along)) = (self.model(), body_key);
        if model.shape(id).is_flat {
            return Err(needs_solid(model.shape(id), key));
        }
        let field = self.step_field(id, step)?;
        let solid = solid_box(&model, id, field.as_ref())?;
        let size = solid.size();
        let shape = model.shape(id);
        // Measured as finely as the lattice is: the same whatever is baked how finely.
        let voxel = Some(size.max_element() / f64::from(along));
        let levels = Interval::new(-size.length(), size.length());
        let distance = self.step_distance(
            (id, step),
            levels,
            &Purpose {
                solid: Solid::Step(id, step),
                shape,
                key,
                span: shape.span,
                voxel,
                around: None,
                choice: shape.distance,
            },
        )?;
        let body = Body::new(field, Arc::new(distance), solid, along, self.cancel())
            .map_err(|error| problem(&model, body_key, None, None, &error))?;
        if !self.is_told((id, step), levels, shape.distance)? {
            self.insides.warnings.extend(body.leak().map(|found| leaks(shape, along, &body, &found)));
        }
        Ok(body)
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
        let purpose = Purpose { solid, shape, key, span: shape.span, voxel, around: None, choice: shape.distance };
        Ok(Arc::new(self.distance_values(id, levels, &purpose)?))
    }
}

/// The distance to all that is outside of a body.
fn beyond(body: &Body) -> Arc<dyn Field> {
    let mut graph = Graph::new();
    let inside = graph.field(body.shared_distance());
    let outside = graph.neg(inside);
    Arc::new(Expression::new(&graph, outside).keeping_values())
}

fn needs_solid(shape: &Shape, key: &str) -> Problem {
    Problem::new(shape.span, format!("`{key}` needs solids, and `{}` is a shape of the plane", shape.name))
        .help(lift_it())
}

/// Why an inside or a feature in it cannot be had.
fn problem(
    model: &Model,
    (id, _, along): BodyKey,
    feature: Option<ShapeId>,
    speed: Option<Span>,
    error: &Error,
) -> Problem {
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
        Error::Speed { at, speed: found } => {
            let problem = format!(
                "the speed at ({:.4}, {:.4}, {:.4}) is {found}: it must be a finite number greater than 0 everywhere inside",
                at.x, at.y, at.z
            );
            Problem::new(speed.unwrap_or(shape.span), problem).help("keep it above 0: \"max(…, 0.01)\"")
        }
        Error::NotANumber(at) => {
            let feature = feature.map_or(shape, |feature| model.shape(feature));
            let problem = format!("F of `{}` is not a number at ({:.4}, {:.4}, {:.4})", feature.name, at.x, at.y, at.z);
            Problem::new(feature.span, problem)
                .help("keep its formulas from dividing by 0, and from roots and logarithms of negative numbers")
        }
    }
}

/// What is worth saying about a wall that is not seen.
fn leaks(shape: &Shape, along: u32, body: &Body, found: &Leak) -> Diagnostic {
    let Leak { at, wall } = found;
    let problem = format!(
        "ways inside of `{}` may lead through a wall about {wall:.2e} units thick around ({:.4}, {:.4}, {:.4}): cells of {:.2e} \
         units are too large to see it",
        shape.name,
        at.x,
        at.y,
        at.z,
        body.edge()
    );
    let cells = (f64::from(along) * body.edge() / found.closing_edge()).ceil();
    let help = if cells <= MOST_ALONG {
        format!("a `lattice` of {cells} sees it")
    } else {
        let thickest = found.wall * cells / MOST_ALONG;
        format!(
            "a `lattice` of {MOST_ALONG}, the most, sees walls of {thickest:.2e} units: make it as thick, or leave it out"
        )
    };
    Diagnostic::warning(shape.span, problem).help(help)
}

/// What is worth saying about features of which nothing tells one from another.
fn same_place(model: &Model, goals: &[Option<ShapeId>], features: &[Arc<Feature>]) -> Option<Diagnostic> {
    let all: Vec<(ShapeId, &Feature)> =
        goals.iter().zip(features).filter_map(|(goal, feature)| Some(((*goal)?, feature.as_ref()))).collect();
    let alike = |(later, (_, two)): (usize, &(ShapeId, &Feature))| {
        (0..later).find(|first| all[*first].1.is_where(two)).map(|first| (first, later))
    };
    let (first, later) = all.iter().enumerate().find_map(alike)?;
    let (first, later) = (model.shape(all[first].0), model.shape(all[later].0));
    let problem = format!("`{}` and `{}` are at the same place", first.name, later.name);
    let help = format!("`{}` counts inside of them and both alike elsewhere: move one, or leave one out", later.name);
    Some(Diagnostic::warning(later.span, problem).help(help))
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
