//! A shape whose every place is moved by formulas.

use std::sync::Arc;

use glam::DVec3;

use crate::field::{Aabb, Expression, Field, Graph};
use crate::node::argument::{Argument, Component};
use crate::node::bend::Mapped;
use crate::node::own_box::known_box;
use crate::node::spec::{Build, Spec};
use crate::text::key::Absent::Nothing;
use crate::text::key::{Key, Kind};
use crate::text::problem::Problem;

/// Moved by formulas.
pub const NODE: Spec = Spec {
    key: Key::new(
        "warp",
        Kind::Formulas,
        Nothing,
        "Moves every place: how far along x, y and z, each a formula of the place where it is then.",
    )
    .unit("units"),
    formula: "f(p − h(p))",
    example: "box = [1, 1, 1.2]\nwarp = [\"0.2*sin(4*z)\", 0, \"0.1*sin(5*x)\"]",
    bend: Some(|build| {
        let ways = components(build, "warp")?;
        let solid = known_box(build)?.and_then(|own| moved_box(&own, &ways));
        let map = Mapped::new(move |graph| {
            let coordinates = [graph.x(), graph.y(), graph.z()];
            std::array::from_fn(|axis| {
                let way = ways[axis].add_to(graph);
                graph.sub(coordinates[axis], way)
            })
        });
        Ok(Arc::new(map.solid(solid)))
    }),
    ..Spec::PLAIN
};

/// A formula of space at one moment.
#[derive(Clone)]
pub(crate) struct Way(Arc<dyn Fn(&mut Graph) -> crate::field::Node + Send + Sync>);

impl Way {
    pub fn add_to(&self, graph: &mut Graph) -> crate::field::Node {
        (self.0)(graph)
    }
}

/// The three formulas of a key at the moment.
pub(crate) fn components(build: &mut dyn Build, key: &str) -> Result<[Way; 3], Problem> {
    let moment = build.moment().clone();
    let given: Vec<Component> = match build.arguments().get(key) {
        Some(Argument::Components(components)) => components.clone(),
        other => unreachable!("`{key}` is {other:?}"),
    };
    let mut ways = Vec::with_capacity(3);
    for component in given {
        ways.push(match component {
            Component::Number(number) => {
                let value = number.at(&moment)?;
                Way(Arc::new(move |graph: &mut Graph| graph.constant(value)))
            }
            Component::Formula(formula) => {
                let reading = build.reading(&formula)?;
                Way(Arc::new(move |graph: &mut Graph| reading.node(graph)))
            }
        });
    }
    Ok(ways.try_into().unwrap_or_else(|_| unreachable!("there are three")))
}

/// A box moved by no more than the formulas say anywhere; `None` where they have no bounds.
fn moved_box(own: &Aabb, ways: &[Way; 3]) -> Option<Aabb> {
    let everywhere = Aabb::new(DVec3::splat(-1e15), DVec3::splat(1e15));
    let mut moved = *own;
    for (axis, way) in ways.iter().enumerate() {
        let mut graph = Graph::new();
        let node = way.add_to(&mut graph);
        let field = Expression::new(&graph, node).keeping_values();
        let mut evaluator = field.evaluator();
        evaluator.enter(&everywhere);
        let bounds = evaluator.bounds();
        if bounds.lo.abs().max(bounds.hi.abs()) > 1e9 {
            return None;
        }
        moved.min[axis] += bounds.lo;
        moved.max[axis] += bounds.hi;
    }
    Some(moved)
}
