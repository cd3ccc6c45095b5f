//! Formulas that read other shapes: `dist('shape')` is the distance of one where it stands, positive inside.

use std::sync::Arc;

use crate::field::{Field, Graph, Interval, Node};
use crate::node::extent::box_of;
use crate::node::id::ShapeId;
use crate::node::measured::Purpose;
use crate::node::solid::Solids;
use crate::text::moment::Moment;
use crate::text::number::formula::Formula;
use crate::text::problem::Problem;

/// A formula at one moment, with the distances that it reads.
#[derive(Clone)]
pub struct Reading {
    formula: Formula,
    moment: Moment,
    /// By their names in the formula.
    distances: Vec<(String, Arc<dyn Field>)>,
}

impl Reading {
    /// As a node of a graph, in its own x, y, z.
    pub fn node(&self, graph: &mut Graph) -> Node {
        let field = |(name, field): &(String, Arc<dyn Field>)| (name.clone(), graph.field(Arc::clone(field)));
        let values: Vec<(String, Node)> = self.distances.iter().map(field).collect();
        let values: Vec<(&str, Node)> = values.iter().map(|(name, node)| (name.as_str(), *node)).collect();
        self.formula.node_of(graph, &self.moment, &values)
    }
}

impl Solids {
    /// A formula of a shape at the moment.
    pub fn reading(&mut self, id: ShapeId, formula: &Formula) -> Result<Reading, Problem> {
        let model = self.model();
        let mut distances: Vec<(String, Arc<dyn Field>)> = Vec::new();
        for (name, shape) in formula.distances() {
            let other = model.shape(id).reads[shape];
            // As far as the shape is large on both sides; beyond, the measured distance goes on.
            let size = box_of(&self.values(other)?).map_or(1.0, |aabb| aabb.size().length().max(f64::MIN_POSITIVE));
            let purpose = Purpose { shape: model.shape(other), key: "dist", span: formula.span() };
            let distance = self.distance_values(other, Interval::new(-size, size), &purpose)?;
            distances.push((name.to_owned(), Arc::new(distance)));
        }
        Ok(Reading { formula: formula.clone(), moment: self.moment().clone(), distances })
    }
}
