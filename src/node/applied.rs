//! What an operation of a scene's own is, and with which numbers a shape asks for it.

use std::sync::Arc;

use crate::field::{Graph, Node};
use crate::node::parameter::Parameter;
use crate::text::moment::Moment;
use crate::text::number::formula::Formula;
use crate::text::number::{BadNumber, Number};
use crate::text::source::Span;

/// An `[operation.NAME]`.
#[derive(Clone, Debug)]
pub struct Operation {
    /// Its name.
    pub name: String,
    /// Names of the shapes' F in the formula, in the order of the shapes.
    pub fields: Vec<String>,
    /// F of the whole.
    pub formula: Formula,
    /// Numbers of its own, each with what holds where a shape leaves it out.
    pub parameters: Vec<Parameter>,
    /// What it is declared to do, and where.
    pub promises: Promises,
    /// How far from their surfaces the shapes' F must be distances; `None` where any F will do.
    pub reach: Option<f64>,
}

/// What an operation declares, each with its place.
#[derive(Clone, Debug, Default)]
pub struct Promises {
    /// The fields with which F rises, by their place.
    pub rises_in: Option<(Vec<usize>, Span)>,
    /// How much F changes at most where no field changes by more than 1.
    pub lipschitz: Option<(f64, Span)>,
}

/// An operation with the numbers that a shape gives it.
#[derive(Clone, Debug)]
pub struct Applied {
    /// The operation.
    pub operation: Arc<Operation>,
    /// The value of each of its parameters.
    pub numbers: Vec<Number>,
}

impl Applied {
    /// F of the whole, from that of the shapes.
    pub fn node(&self, graph: &mut Graph, fields: &[Node], moment: &Moment) -> Result<Node, BadNumber> {
        let Operation { fields: names, parameters, formula, .. } = &*self.operation;
        let mut known: Vec<(&str, Node)> = Vec::with_capacity(names.len() + parameters.len());
        for (parameter, number) in parameters.iter().zip(&self.numbers) {
            known.push((&parameter.name, graph.constant(number.at(moment)?)));
        }
        known.extend(names.iter().map(String::as_str).zip(fields.iter().copied()));
        Ok(formula.node_of(graph, moment, &known))
    }
}
