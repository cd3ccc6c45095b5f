//! Operations of a scene's own: F as a formula of the F of some shapes.

use crate::field::{Aabb, Graph, Interval, Node, Side, Slope};
use crate::node::applied::{Applied, Promises};
use crate::node::spec::{Build, Carries, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};
use crate::text::moment::Moment;
use crate::text::problem::Problem;

/// The row of all shapes that are made by an operation of the scene's own. No scene can name it: its key is the operation's.
pub static OPERATION: Spec = Spec {
    key: Key::new("operation", Kind::Shapes(1), Required, "The shapes, one for each of the operation's fields."),
    carries: Carries::Blend,
    measures: |arguments| arguments.applied().is_some_and(|applied| applied.operation.reach.is_some()),
    build,
    ..Spec::PLAIN
};

fn build(build: &mut dyn Build) -> Result<Node, Problem> {
    let applied = build.arguments().applied().expect("it comes with the shapes").clone();
    let shapes = build.arguments().shapes("operation").cloned().unwrap_or_default();
    let mut fields = Vec::with_capacity(shapes.len());
    for id in shapes {
        fields.push(match applied.operation.reach {
            None => build.shape(id)?,
            Some(reach) => build.shape_distance(id, Interval::new(-reach, reach), "operation")?,
        });
    }
    let moment = build.moment().clone();
    let graph = build.graph();
    let node = applied.node(graph, &fields, &moment)?;
    let Promises { rises_in, lipschitz } = &applied.operation.promises;
    if let Some((bound, _)) = lipschitz
        && let Some(steepest) = steepest(graph, &fields)
    {
        graph.no_steeper(node, bound * steepest);
    }
    if rises_in.as_ref().is_some_and(|(rising, _)| rising.len() == fields.len())
        && graph.known_box(node).is_none()
        && let Some(aabb) = box_around(graph, &applied, &fields, &moment)?
    {
        graph.bounded(node, aabb);
    }
    Ok(node)
}

/// The greatest of the fields' bounds of |∇F|, where all are known.
fn steepest(graph: &Graph, fields: &[Node]) -> Option<f64> {
    fields.iter().try_fold(0.0_f64, |most, field| match graph.slope(*field) {
        Slope::Exact { .. } => Some(most.max(1.0)),
        Slope::Lipschitz(bound) => Some(most.max(bound)),
        Slope::Unknown => None,
    })
}

/// A box outside of which F < 0, of an F that rises with every field: where every field is below a level at which F is
/// negative. Outside of a solid's box grown by so much, a distance is below that level.
fn box_around(graph: &mut Graph, applied: &Applied, fields: &[Node], moment: &Moment) -> Result<Option<Aabb>, Problem> {
    /// Where nothing is negative within so many times the longest side, the interval bounds of F decide.
    const MOST_SIDES: f64 = 4.0;
    let mut around: Option<Aabb> = None;
    for field in fields {
        let Some(aabb) = graph.known_box(*field).filter(|_| graph.slope(*field).is_exact(Side::Outside)) else {
            return Ok(None);
        };
        around = Some(around.map_or(aabb, |known| known.union(aabb)));
    }
    let Some(around) = around else { return Ok(None) };
    let side = around.size().max_element();
    let mut beyond = 0.0;
    while beyond <= MOST_SIDES * side {
        let mut apart = Graph::new();
        let level = apart.constant(-beyond);
        let node = applied.node(&mut apart, &vec![level; fields.len()], moment)?;
        if apart.as_constant(node).is_some_and(|value| value < 0.0) {
            return Ok(Some(around.grown(beyond)));
        }
        beyond = (2.0 * beyond).max(side / 64.0);
    }
    Ok(None)
}
