//! When something that starts at other shapes, or at the surface, arrives inside.

use std::sync::Arc;

use crate::attribute::{Journey, Sources, Travel, TravelError};
use crate::field::{Expression, Field, Graph};
use crate::node::argument::Component;
use crate::node::extent::box_of;
use crate::node::painted::Paint;
use crate::node::source::{Source, Sourcing};
use crate::text::key::Absent::{Required, Words};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// Arrival times.
pub const NODE: Source<1> = Source {
    key: Key::new(
        "travel",
        Kind::ShapesOr("surface"),
        Required,
        "When something arrives that starts at these shapes, which stand in this one's own space, or at `\"surface\"`, and goes \
         inside the shape only: fire, frost, growth. 0 where it starts, everywhere else the least time of all ways. Places \
         outside have that of the nearest place inside. Every piece of the shape must be reached.",
    )
    .unit("s"),
    parameters: &[Key::new(
        "speed",
        Kind::OfSpace,
        Words("1"),
        "How fast it goes, greater than 0 everywhere inside.",
    )
    .limit(Limit::Positive)
    .unit("units/s")],
    formula: "min over all ways inside of ∫ ds/speed: |∇a| = 1/speed",
    example: "{ travel = \"surface\", speed = \"1 + 0.5*x\" }",
    build: arrival,
    ..Source::PLAIN
};

fn arrival(source: &mut dyn Sourcing<1>) -> Result<Paint<1>, Problem> {
    let solid = source.solid()?;
    let aabb = box_of(solid.as_ref()).map_err(|error| source.problem(&error.to_string()))?;
    let shapes = source.arguments().shapes("travel").cloned().unwrap_or_default();
    let sources = match shapes.as_slice() {
        [] => Sources::Surface,
        shapes => Sources::Solids(shapes.iter().map(|shape| source.shape(*shape)).collect::<Result<_, _>>()?),
    };
    let component = source.arguments().component("speed").cloned();
    let speed = match &component {
        Some(component) => source.component(component)?,
        None => one(),
    };
    let (voxel, cancel) = (source.voxel(), source.cancel());
    let found =
        Travel::new(&Journey { solid: solid.as_ref(), aabb, sources, speed: speed.as_ref(), voxel, cancel: &cancel });
    found.map(Paint::of).map_err(|error| problem(source, component.as_ref(), &error))
}

/// A speed of 1.
fn one() -> Arc<dyn Field> {
    let mut graph = Graph::new();
    let node = graph.constant(1.0);
    Arc::new(Expression::new(&graph, node))
}

fn problem(source: &dyn Sourcing<1>, speed: Option<&Component>, error: &TravelError) -> Problem {
    let problem = source.problem(&error.to_string());
    match error {
        TravelError::Speed { .. } => {
            let problem = speed.map(Component::span).map_or(problem, |span| Problem::new(span, error.to_string()));
            problem.help("keep it above 0: \"max(…, 0.01)\"")
        }
        TravelError::NoSource => {
            problem.help("move a shape of `travel` to where it overlaps this one, in its own space")
        }
        TravelError::Unreached { .. } => problem
            .help("add a shape there to `travel`, join the pieces, or bake finer where a neck is thinner than a voxel"),
        TravelError::Surface(_) => problem,
    }
}
