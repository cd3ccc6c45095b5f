//! Formulas that read what no formula gives: `dist('shape')` is the distance of a shape where it stands, positive inside, and
//! an attribute that is a table has its name.

use std::sync::Arc;

use crate::field::{Field, Graph, Node};
use crate::text::moment::Moment;
use crate::text::number::formula::Formula;

/// A formula at one moment, with the fields that it reads.
#[derive(Clone)]
pub struct Reading {
    formula: Formula,
    moment: Moment,
    /// By their names in the formula.
    fields: Vec<(String, Arc<dyn Field>)>,
}

impl Reading {
    /// A formula at a moment, with the fields that it reads by their names in it.
    pub fn new(formula: Formula, moment: Moment, fields: Vec<(String, Arc<dyn Field>)>) -> Self {
        Self { formula, moment, fields }
    }

    /// As a node of a graph, in its own x, y, z.
    pub fn node(&self, graph: &mut Graph) -> Node {
        let field = |(name, field): &(String, Arc<dyn Field>)| (name.clone(), graph.field(Arc::clone(field)));
        let values: Vec<(String, Node)> = self.fields.iter().map(field).collect();
        let values: Vec<(&str, Node)> = values.iter().map(|(name, node)| (name.as_str(), *node)).collect();
        self.formula.node_of(graph, &self.moment, &values)
    }
}
