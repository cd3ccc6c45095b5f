//! Formulas of a scene: read with the names that a scene gives them, evaluated at a moment.

use std::sync::Arc;

use crate::field::{self, FormulaError, Graph, Node};

use crate::text::diagnostic::Diagnostic;
use crate::text::moment::Moment;
use crate::text::source::{Sources, Span};

/// The names of the scene's parameters, in their order.
pub type Names = Arc<[String]>;

/// Names that formulas know by themselves.
pub const RESERVED: [&str; 7] = ["x", "y", "z", "t", "frame", "time", "pi"];

/// A formula that was read and whose names are all known.
#[derive(Clone, Debug)]
pub struct Formula {
    parsed: Arc<field::Formula>,
    names: Names,
}

impl Formula {
    /// A formula of t, frame, time and parameters.
    pub fn of_time(text: &str, names: Names) -> Result<Self, Vec<FormulaProblem>> {
        let formula = Self::parse(text, names);
        let mut graph = Graph::new();
        let known = formula.known(field::Names::new(), &Moment::any(&formula.names));
        formula.parsed.compile(&mut graph, &known).map_err(problems)?;
        Ok(formula)
    }

    /// A formula of x, y, z, t, frame, time and parameters.
    pub fn of_space(text: &str, names: Names) -> Result<Self, Vec<FormulaProblem>> {
        let formula = Self::parse(text, names);
        let mut graph = Graph::new();
        let known = formula.known(field::Names::space(&mut graph), &Moment::any(&formula.names));
        formula.parsed.compile(&mut graph, &known).map_err(problems)?;
        Ok(formula)
    }

    fn parse(text: &str, names: Names) -> Self {
        Self { parsed: Arc::new(field::Formula::parse(text)), names }
    }

    /// What names mean at a moment.
    fn known(&self, space: field::Names, moment: &Moment) -> field::Names {
        let time = space.number("t", moment.t).number("frame", moment.frame).number("time", moment.time);
        let values = moment.parameters.iter().copied();
        self.names.iter().zip(values).fold(time, |known, (name, value)| known.number(name, value))
    }

    /// The names in it, functions not among them.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.parsed.names().into_iter()
    }

    /// Its value at a moment; NaN where it has none. For formulas of time.
    pub fn number(&self, moment: &Moment) -> f64 {
        self.parsed.evaluate(&self.known(field::Names::new(), moment)).unwrap_or(f64::NAN)
    }

    /// As a node of a graph, in its own x, y, z.
    pub fn node(&self, graph: &mut Graph, moment: &Moment) -> Node {
        let space = field::Names::space(graph);
        let known = self.known(space, moment);
        // All names were looked up when the scene was read.
        self.parsed.compile(graph, &known).unwrap_or_else(|_| graph.constant(f64::NAN))
    }
}

fn problems(errors: Vec<FormulaError>) -> Vec<FormulaProblem> {
    errors.into_iter().map(FormulaProblem::from).collect()
}

impl From<FormulaError> for FormulaProblem {
    fn from(error: FormulaError) -> Self {
        let help = error.suggestion.map_or_else(String::new, |name| format!("did you mean `{name}`?"));
        Self { message: error.message, at: error.span, help }
    }
}

/// A problem of a formula: what is wrong, and which bytes of the formula's own text it is about.
#[derive(Clone, Debug, PartialEq)]
pub struct FormulaProblem {
    /// What is wrong.
    pub message: String,
    /// Which bytes of the formula.
    pub at: std::ops::Range<usize>,
    /// What to do next.
    pub help: String,
}

impl FormulaProblem {
    /// As a message that points into the string in the scene.
    pub fn into_diagnostic(self, sources: &Sources, string: Span, text: &str) -> Diagnostic {
        let marked = sources.text(string);
        // Where the string has escapes, the formula's bytes are not the scene's: the whole string is marked.
        let span = match marked.find(text) {
            Some(quote) if !text.is_empty() => {
                let start = (string.start + quote + self.at.start).min(string.end);
                Span {
                    source: string.source,
                    start,
                    end: (string.start + quote + self.at.end).clamp(start, string.end),
                }
            }
            _ => string,
        };
        Diagnostic::error(span, self.message).help(self.help)
    }
}
