//! Formulas that read other shapes: `dist('shape')` is the distance of one where it stands, positive inside.

use std::sync::Arc;

use crate::field::{Field, Graph, Node};
use crate::text::moment::Moment;
use crate::text::number::formula::Formula;

/// A formula at one moment, with the distances that it reads.
#[derive(Clone)]
pub struct Reading {
    formula: Formula,
    moment: Moment,
    /// By their names in the formula.
    distances: Vec<(String, Arc<dyn Field>)>,
}

impl Reading {
    /// A formula at a moment, with the distances that it reads by their names in it.
    pub fn new(formula: Formula, moment: Moment, distances: Vec<(String, Arc<dyn Field>)>) -> Self {
        Self { formula, moment, distances }
    }

    /// As a node of a graph, in its own x, y, z.
    pub fn node(&self, graph: &mut Graph) -> Node {
        let field = |(name, field): &(String, Arc<dyn Field>)| (name.clone(), graph.field(Arc::clone(field)));
        let values: Vec<(String, Node)> = self.distances.iter().map(field).collect();
        let values: Vec<(&str, Node)> = values.iter().map(|(name, node)| (name.as_str(), *node)).collect();
        self.formula.node_of(graph, &self.moment, &values)
    }
}
