//! Formulas of a scene: read with the names that a scene gives them, evaluated at a moment.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::field::{self, FormulaError, Graph, Node};

use crate::text::diagnostic::Diagnostic;
use crate::text::moment::Moment;
use crate::text::number::Number;
use crate::text::source::{Sources, Span};

/// The names of the scene's parameters, in their order.
pub type Names = Arc<[String]>;

/// Names that formulas know by themselves.
pub const RESERVED: [&str; 7] = ["x", "y", "z", "t", "frame", "time", "pi"];

/// What formulas may name beside places and time.
#[derive(Clone, Debug, Default)]
pub struct Scope {
    /// The scene's parameters, in the order of a moment's values.
    pub parameters: Names,
    /// What has a name where the formula stands, each after those that it names.
    pub named: Arc<[Named]>,
}

/// Something with a name in formulas.
#[derive(Clone, Debug)]
pub struct Named {
    /// The name.
    pub name: String,
    /// What it stands for.
    pub value: NamedValue,
}

/// What a name in formulas stands for.
#[derive(Clone, Debug)]
pub enum NamedValue {
    /// A formula.
    Formula(Arc<field::Formula>),
    /// A number by keys, or one that stands still.
    Number(Number),
    /// What no formula gives, a number that differs from place to place: whoever builds the formula has it.
    Given,
}

/// A formula that was read and whose names are all known.
#[derive(Clone, Debug)]
pub struct Formula(Arc<Read>);

#[derive(Debug)]
struct Read {
    parsed: field::Formula,
    scope: Scope,
    span: Span,
}

impl Formula {
    /// A formula of t, frame, time, and what else has a name.
    pub fn of_time(text: &str, span: Span, scope: Scope) -> Result<Self, Vec<FormulaProblem>> {
        let formula = Self::parse(text, span, scope);
        let checked = formula.check(&mut Graph::new(), field::Names::new());
        checked.map_err(|errors| problems(errors.into_iter().map(|error| formula.explained(error, text)).collect()))?;
        Ok(formula)
    }

    /// A formula of x, y, z, t, frame, time, distances of shapes, and what else has a name.
    pub fn of_space(text: &str, span: Span, scope: Scope) -> Result<Self, Vec<FormulaProblem>> {
        let formula = Self::parse(text, span, scope.clone());
        let distances = formula.distances().map(|(name, _)| name.to_owned());
        let values: Vec<String> = distances.chain(formula.given().map(str::to_owned)).collect();
        Self::of_values(text, span, scope, &values)
    }

    /// A formula of space with more names, each a number that differs from place to place.
    pub fn of_values(text: &str, span: Span, scope: Scope, values: &[String]) -> Result<Self, Vec<FormulaProblem>> {
        let formula = Self::parse(text, span, scope);
        let mut graph = Graph::new();
        let space = field::Names::space(&mut graph);
        let any = graph.x();
        let known = values.iter().fold(space, |known, name| known.node(name, any));
        formula.check(&mut graph, known).map_err(problems)?;
        Ok(formula)
    }

    fn parse(text: &str, span: Span, scope: Scope) -> Self {
        Self(Arc::new(Read { parsed: field::Formula::parse(text), scope, span }))
    }

    /// Where the scene has it.
    pub fn span(&self) -> Span {
        self.0.span
    }

    /// The distances that it reads: each by its name in the formula, and the name of the shape.
    pub fn distances(&self) -> impl Iterator<Item = (&str, &str)> {
        self.names().filter_map(|name| Some((name, name.strip_prefix("dist('")?.strip_suffix("')")?)))
    }

    /// Those of its names that no formula gives.
    pub fn given(&self) -> impl Iterator<Item = &str> {
        let used: BTreeSet<&str> = self.names().collect();
        let is_given = |named: &&Named| matches!(named.value, NamedValue::Given);
        let given = self.0.scope.named.iter().filter(is_given).map(|named| named.name.as_str());
        given.filter(move |name| used.contains(name))
    }

    /// At some moment: which one does not matter.
    fn check(&self, graph: &mut Graph, space: field::Names) -> Result<(), Vec<FormulaError>> {
        self.compile(graph, space, &Moment::any(&self.0.scope.parameters)).map(|_| ())
    }

    /// An error of a formula of time, in words that say why a name that is known elsewhere is not known here.
    fn explained(&self, error: FormulaError, text: &str) -> FormulaError {
        let name = text.get(error.span.clone()).unwrap_or_default();
        if name.starts_with("dist") && name.ends_with(')') {
            let message = "`dist` reads a place, and one number is needed here".to_owned();
            return FormulaError { message, suggestion: None, ..error };
        }
        if self.0.scope.named.iter().all(|named| named.name != name) {
            return error;
        }
        let message = format!("`{name}` differs from place to place, and one number is needed here");
        FormulaError { message, suggestion: None, ..error }
    }

    fn compile(&self, graph: &mut Graph, space: field::Names, moment: &Moment) -> Result<Node, Vec<FormulaError>> {
        let time = space.number("t", moment.t).number("frame", moment.frame).number("time", moment.time);
        let values = moment.parameters.iter().copied();
        let parameters = self.0.scope.parameters.iter().zip(values);
        let mut known = parameters.fold(time, |known, (name, value)| known.number(name, value));
        let used: BTreeSet<&str> = self.names().collect();
        for Named { name, value } in self.0.scope.named.iter().filter(|named| used.contains(named.name.as_str())) {
            known = match value {
                NamedValue::Formula(formula) => match formula.compile(graph, &known) {
                    Ok(node) => known.node(name, node),
                    // Of places, where there are none: whoever names it is told.
                    Err(_) => known,
                },
                NamedValue::Number(number) => known.number(name, number.at(moment).unwrap_or(f64::NAN)),
                // It is among `space`, where there are places.
                NamedValue::Given => known,
            };
        }
        self.0.parsed.compile(graph, &known)
    }

    /// The names in it and in what these stand for, functions not among them.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let mut names = self.0.parsed.names();
        for named in self.0.scope.named.iter().rev() {
            if let NamedValue::Formula(formula) = &named.value
                && names.contains(named.name.as_str())
            {
                names.extend(formula.names());
            }
        }
        names.into_iter()
    }

    /// The scene's parameters among its names, by their place.
    pub fn parameters(&self) -> impl Iterator<Item = usize> {
        let used: BTreeSet<&str> = self.names().collect();
        let places = self.0.scope.parameters.iter().enumerate();
        places.filter(move |(_, name)| used.contains(name.as_str())).map(|(place, _)| place)
    }

    /// The numbers that its names stand for.
    pub fn numbers(&self) -> impl Iterator<Item = &Number> {
        let used: BTreeSet<&str> = self.names().collect();
        self.0.scope.named.iter().filter_map(move |named| match &named.value {
            NamedValue::Number(number) if used.contains(named.name.as_str()) => Some(number),
            _ => None,
        })
    }

    /// Its value at a moment; NaN where it has none. For formulas of time.
    pub fn number(&self, moment: &Moment) -> f64 {
        let mut graph = Graph::new();
        let node = self.compile(&mut graph, field::Names::new(), moment);
        let value = node.ok().and_then(|node| graph.as_constant(node));
        value.filter(|value| value.is_finite()).unwrap_or(f64::NAN)
    }

    /// As a node of a graph, in its own x, y, z, with values of names that it knows beside those of its scope.
    pub fn node_of(&self, graph: &mut Graph, moment: &Moment, values: &[(&str, Node)]) -> Node {
        let space = field::Names::space(graph);
        let known = values.iter().fold(space, |known, (name, node)| known.node(name, *node));
        // All names were looked up when the scene was read.
        self.compile(graph, known, moment).unwrap_or_else(|_| graph.constant(f64::NAN))
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
