//! Formulas: `"0.01 - x^2 - y^2 - z^2"`, `"-1.3 + 0.2*sin(2*pi*t)"`.
//!
//! `+ − * / ^`, comparisons, parentheses, numbers, names and [functions]; `^` binds tightest and to the right, so
//! `-x^2` is `-(x^2)`, comparisons loosest. A formula is parsed once and compiled with the [`Names`] known where it stands: to a node of
//! a graph, or, where all names are numbers, to a number. Both are the same operations, so they mean the same.

mod functions;
mod parser;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::ops::Range;

use super::graph::{Graph, Node};
use super::op::Binary;
pub use functions::functions;
pub(super) use functions::{Function, any_number, fold, function};

/// What is wrong with a formula, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FormulaError {
    /// The bytes of the formula that are wrong.
    pub span: Range<usize>,
    /// What is wrong.
    pub message: String,
    /// The nearest name that would be right.
    pub suggestion: Option<String>,
}

impl fmt::Display for FormulaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.message)?;
        match &self.suggestion {
            Some(name) => write!(f, "; did you mean `{name}`?"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for FormulaError {}

/// The candidate that looks most like a word, if any looks like it at all.
fn nearest<'a>(word: &str, candidates: impl Iterator<Item = &'a str>) -> Option<String> {
    candidates
        .map(|candidate| (strsim::damerau_levenshtein(word, candidate), candidate))
        .filter(|(distance, candidate)| *distance <= 1 + candidate.len() / 4 && *distance < word.len())
        .min()
        .map(|(_, candidate)| candidate.to_owned())
}

/// Names in a row.
fn quoted<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// What names mean where a formula stands. `pi` is always known.
#[derive(Clone, Debug, Default)]
pub struct Names {
    values: BTreeMap<String, Meaning>,
}

#[derive(Clone, Copy, Debug)]
enum Meaning {
    Number(f64),
    Node(Node),
}

impl Names {
    /// Only `pi`.
    pub fn new() -> Self {
        Self::default()
    }

    /// The coordinates `x`, `y`, `z` of a graph.
    pub fn space(graph: &mut Graph) -> Self {
        let (x, y, z) = (graph.x(), graph.y(), graph.z());
        Self::new().node("x", x).node("y", y).node("z", z)
    }

    /// With a name for a number; an earlier meaning of the name is forgotten.
    pub fn number(mut self, name: &str, value: f64) -> Self {
        self.values.insert(name.to_owned(), Meaning::Number(value));
        self
    }

    /// With a name for a node of the graph that formulas are compiled into.
    pub fn node(mut self, name: &str, node: Node) -> Self {
        self.values.insert(name.to_owned(), Meaning::Node(node));
        self
    }

    fn meaning(&self, name: &str) -> Option<Meaning> {
        let known = self.values.get(name).copied();
        known.or((name == "pi").then_some(Meaning::Number(std::f64::consts::PI)))
    }
}

/// A parsed formula.
#[derive(Clone, Debug)]
pub struct Formula {
    /// Arguments come before what they are arguments of; the last is the whole.
    terms: Vec<Term>,
    /// What is wrong whatever names mean.
    errors: Vec<FormulaError>,
    length: usize,
}

#[derive(Clone, Debug)]
struct Term {
    what: What,
    span: Range<usize>,
}

#[derive(Clone, Debug)]
enum What {
    Number(f64),
    Name(String),
    Negated(usize),
    Binary(Binary, usize, usize),
    /// 1 less the operation.
    Not(Binary, usize, usize),
    Call(Function, Vec<usize>),
}

impl Formula {
    /// Parses a formula. What is wrong with it is said, together with names that mean nothing, when it is compiled.
    pub fn parse(text: &str) -> Self {
        let (terms, errors) = parser::parse(text);
        Self { terms, errors, length: text.len() }
    }

    /// The names it uses, functions not among them.
    pub fn names(&self) -> BTreeSet<&str> {
        self.terms
            .iter()
            .filter_map(|term| match &term.what {
                What::Name(name) => Some(name.as_str()),
                _ => None,
            })
            .collect()
    }

    /// The formula as a node of a graph; else all that is wrong with it, in the order of the text.
    pub fn compile(&self, graph: &mut Graph, names: &Names) -> Result<Node, Vec<FormulaError>> {
        self.check(|name| names.meaning(name).is_none().then(|| unknown(name, names)))?;
        let mut nodes: Vec<Node> = Vec::with_capacity(self.terms.len());
        for term in &self.terms {
            let node = match &term.what {
                What::Number(value) => graph.constant(*value),
                What::Name(name) => match names.meaning(name) {
                    Some(Meaning::Number(value)) => graph.constant(value),
                    Some(Meaning::Node(node)) => node,
                    None => graph.constant(f64::NAN),
                },
                What::Negated(a) => graph.neg(nodes[*a]),
                What::Binary(operation, a, b) => graph.binary(*operation, nodes[*a], nodes[*b]),
                What::Not(operation, a, b) => {
                    let holds = graph.binary(*operation, nodes[*a], nodes[*b]);
                    graph.linear(holds, -1.0, 1.0)
                }
                What::Call(function, arguments) => {
                    let arguments: Vec<Node> = arguments.iter().map(|argument| nodes[*argument]).collect();
                    function.build(graph, &arguments)
                }
            };
            nodes.push(node);
        }
        Ok(nodes.last().copied().unwrap_or_else(|| graph.constant(f64::NAN)))
    }

    /// Fails where anything is wrong, also with a name that `wrong` has something to say about.
    fn check(&self, wrong: impl Fn(&str) -> Option<(String, Option<String>)>) -> Result<(), Vec<FormulaError>> {
        let mut errors = self.errors.clone();
        errors.extend(self.terms.iter().filter_map(|term| {
            let What::Name(name) = &term.what else { return None };
            let (message, suggestion) = wrong(name)?;
            Some(FormulaError { span: term.span.clone(), message, suggestion })
        }));
        errors.sort_by_key(|error| error.span.start);
        if errors.is_empty() { Ok(()) } else { Err(errors) }
    }

    /// The formula as a number. A name for a node, a name that is not known, and a result that is no finite
    /// number are errors.
    pub fn evaluate(&self, names: &Names) -> Result<f64, Vec<FormulaError>> {
        self.check(|name| match names.meaning(name) {
            Some(Meaning::Node(_)) => {
                Some((format!("`{name}` differs from point to point, but one number is needed here"), None))
            }
            Some(Meaning::Number(_)) => None,
            None => Some(unknown(name, names)),
        })?;
        let mut graph = Graph::new();
        let node = self.compile(&mut graph, names)?;
        graph.as_constant(node).filter(|value| value.is_finite()).ok_or_else(|| {
            vec![FormulaError {
                span: 0..self.length,
                message: "the formula has no finite value here: look for a division by zero, or a root or logarithm \
                          of a negative number"
                    .to_owned(),
                suggestion: None,
            }]
        })
    }
}

/// What is to be said about a name that means nothing, and the nearest that means something.
fn unknown(name: &str, names: &Names) -> (String, Option<String>) {
    if let Some((_, usage, _)) = functions().find(|(function, ..)| *function == name) {
        return (format!("`{name}` is a function: write `{usage}`"), None);
    }
    // Names that no formula can hold are hidden ones.
    let known = names.values.keys().map(String::as_str).filter(|name| !name.contains('/')).chain(["pi"]);
    let suggestion = nearest(name, known.clone());
    let mut message = format!("nothing here is called `{name}`");
    if suggestion.is_none() {
        message += &format!("; known are {}", quoted(known));
    }
    (message, suggestion)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Expression, Field};
    use glam::DVec3;

    fn number(text: &str) -> Result<f64, Vec<FormulaError>> {
        Formula::parse(text).evaluate(&Names::new().number("t", 0.25).number("size", 3.0))
    }

    #[test]
    fn numbers_follow_the_usual_rules() {
        let cases = [
            ("1 + 2 * 3", 7.0),
            ("(1 + 2) * 3", 9.0),
            ("-2^2", -4.0),
            ("2^3^2", 512.0),
            ("2^-1", 0.5),
            ("1 - 2 - 3", -4.0),
            ("8 / 4 / 2", 1.0),
            (".5e1 + 1.5E-1", 5.15),
            ("- - 3", 3.0),
            ("-1.3 + 0.2*sin(2*pi*t)", -1.1),
            ("min(3, 1, 2) + max(size, 4)", 5.0),
            ("clamp(7, 0, 2) + mix(1, 3, t)", 3.5),
            ("smoothstep(0, 1, 0.5) + step(2, 3)", 1.5),
            ("mod(-1, 3) + fract(2.25) + ceil(0.1) + round(1.5)", 5.25),
            ("length(2, 3, 6) + abs(-1) + sign(-9)", 7.0),
            ("pow(4, 1.5) + sqrt(16) + cbrt(27)", 15.0),
            ("(1 < 2) + (2 <= 2)*10 + (3 > 2)*100 + (2 >= 3)*1000 + (2 == 2)*1e4 + (2 != 2)*1e5", 10111.0),
            ("1 + 1 < 3", 1.0),
            ("if(t < 0.5, 7, sqrt(-1)) + if(size, 1, 2) + if(0, 1, 20)", 28.0),
            ("atan2(0, -1) - pi + exp(0) + log(1) + tan(0) + tanh(0) + cos(0)", 2.0),
        ];
        for (text, wanted) in cases {
            let value = number(text).expect(text);
            assert!((value - wanted).abs() < 1e-14, "{text} = {value}, not {wanted}");
        }
    }

    #[test]
    fn errors_point_at_the_place() {
        let cases = [
            ("1 + sizw", 4..8, Some("size")),
            ("1 + sni(t)", 4..7, Some("sin")),
            ("1 +", 3..3, None),
            ("2 t", 2..3, None),
            ("(1 + 2", 0..1, None),
            ("1 + 2)", 5..6, None),
            ("clamp(1, 2)", 0..11, None),
            ("1 § 2", 2..4, None),
            ("1e", 0..2, None),
            ("0 < t < 1", 6..7, None),
            ("t = 1", 2..3, None),
            ("t > 0 && t < 1", 6..7, None),
            ("", 0..0, None),
            ("sqrt + 1", 0..4, None),
            ("1 / 0", 0..5, None),
            ("x", 0..1, None),
        ];
        for (text, span, suggestion) in cases {
            let errors = number(text).expect_err(text);
            let [error] = errors.as_slice() else { panic!("{text}: {errors:?}") };
            assert_eq!((error.span.clone(), error.suggestion.as_deref()), (span, suggestion), "{text}: {error}");
        }
    }

    #[test]
    fn all_errors_of_a_formula_come_together() {
        let errors = number("sni(foo) + clamp(1, bar) * wobble(t) - sizw +").expect_err("wrong");
        let found: Vec<(usize, String)> = errors.iter().map(|error| (error.span.start, error.to_string())).collect();
        for (i, (start, part)) in [
            (0, "no function `sni`; did you mean `sin`?"),
            (4, "nothing here is called `foo`; known are `size`, `t`, `pi`"),
            (11, "`clamp` takes 3 arguments, `clamp(x, least, greatest)`, not 2"),
            (20, "nothing here is called `bar`"),
            (27, "no function `wobble`; there are `abs`, `angle`,"),
            (39, "did you mean `size`?"),
            (45, "the formula ends where"),
        ]
        .into_iter()
        .enumerate()
        {
            assert!(found[i].0 == start && found[i].1.contains(part), "{part}: {found:#?}");
        }
        assert_eq!(found.len(), 7, "{found:#?}");
    }

    /// The page lists what formulas know; every usage is one that formulas take.
    #[test]
    fn usages_are_right() {
        for (name, usage, text) in functions() {
            assert!(usage.starts_with(&format!("{name}(")) && !text.is_empty(), "{name}");
            let numbers = usage.replace(['…', ' '], "");
            let (_, arguments) = numbers.split_once('(').expect("arguments");
            let count = arguments.trim_end_matches(')').split(',').filter(|name| !name.is_empty()).count();
            let call = format!("{name}({})", vec!["0.5"; count].join(", "));
            assert!(number(&call).is_ok() || name == "smoothstep", "{call}: {:?}", number(&call));
        }
    }

    /// What the page says of places without a value.
    #[test]
    fn what_has_no_value_is_not_a_number() {
        let value = |text: &str| {
            let mut graph = Graph::new();
            let node = Formula::parse(text).compile(&mut graph, &Names::new()).expect(text);
            graph.as_constant(node).expect("a number")
        };
        for text in
            ["sqrt(-1)", "ln(-1)", "log(-2)", "0/0", "pow(-8, 1/3)", "(-8)^0.5", "mod(1, 0)", "smoothstep(1, 1, 1)"]
        {
            assert!(value(text).is_nan(), "{text} = {}", value(text));
        }
        for (text, wanted) in
            [("1/0", f64::INFINITY), ("ln(0)", f64::NEG_INFINITY), ("cbrt(-8)", -2.0), ("(-2)^3", -8.0)]
        {
            assert_eq!(value(text), wanted, "{text}");
        }
        for (text, wanted) in [("round(-2.5)", -2.0), ("sign(0)", 0.0), ("step(1, 1)", 1.0), ("mod(-1, 3)", 2.0)] {
            assert_eq!(value(text), wanted, "{text}");
        }
    }

    /// A condition in the midst of other operations, at each width, against branches of this language; and its bounds.
    #[test]
    fn a_choice_is_one_of_its_two() {
        use crate::field::tests::Samples;
        use crate::field::{Aabb, BATCH, Evaluator, Gradients, VectorWidth};
        let mut graph = Graph::new();
        let names = Names::space(&mut graph);
        let text = "if(x + y > 0.3, sqrt(x + y) - z, if(z >= x, 2*z, -x*y)) + 0.5*x";
        let node = Formula::parse(text).compile(&mut graph, &names).expect("it compiles");
        assert_eq!(graph.slope(node), crate::field::Slope::Unknown);
        let wanted = |p: DVec3| {
            let (value, slope) = if p.x + p.y > 0.3 {
                let root = (p.x + p.y).sqrt();
                (root - p.z, DVec3::new(0.5 / root, 0.5 / root, -1.0))
            } else if p.z >= p.x {
                (2.0 * p.z, DVec3::new(0.0, 0.0, 2.0))
            } else {
                (-p.x * p.y, DVec3::new(-p.y, -p.x, 0.0))
            };
            (value + 0.5 * p.x, slope + DVec3::X * 0.5)
        };
        let world = Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0));
        let mut samples = Samples::new(5);
        let points = samples.batch(&world, 400);
        for width in VectorWidth::ALL {
            let field = Expression::new(&graph, node);
            assert!(field.jumps());
            let mut evaluator = field.evaluator_of_width(width);
            let (mut values, mut out) = ([0.0; BATCH], Gradients::new());
            evaluator.values(&points, &mut values);
            evaluator.gradients(&points, &mut out);
            for i in 0..points.len {
                let p = points.position(i);
                let (value, slope) = wanted(p);
                assert!((field.reference(p) - value).abs() < 1e-12 && values[i] == out.value[i]);
                assert!((f64::from(values[i]) - value).abs() < 1e-6, "{} {value} at {p}", values[i]);
                assert!((out.gradient(i).as_dvec3() - slope).length() < 1e-5 * (1.0 + slope.length()), "at {p}");
            }
            for _ in 0..200 {
                let min = samples.within(&world);
                let region = Aabb::new(min, min + samples.next() * 0.2);
                evaluator.enter(&region);
                let bounds = evaluator.bounds();
                for _ in 0..10 {
                    let p = samples.within(&region);
                    assert!(bounds.contains(wanted(p).0), "{bounds:?} at {p}");
                }
                evaluator.leave();
            }
        }
    }

    #[test]
    fn depth_and_length_are_no_danger() {
        let deep = "(".repeat(100_000);
        for text in [deep, "-".repeat(100_000), "2^".repeat(100_000)] {
            assert!(number(&text).is_err());
        }
        let long = vec!["t"; 20_000].join("+");
        assert_eq!(number(&long), Ok(5000.0));
    }

    #[test]
    fn a_shape_is_its_formula_anywhere() {
        let formula = Formula::parse("0.01 - (x - 100000)^2 - y^2 - z^2");
        let mut graph = Graph::new();
        let names = Names::space(&mut graph);
        let node = formula.compile(&mut graph, &names).expect("it compiles");
        let field = Expression::new(&graph, node);
        assert_eq!(field.operations(), 1);
        let bounds = field.bounding_box().expect("bounds find the ball");
        assert!((bounds.max - DVec3::new(100_000.1, 0.1, 0.1)).abs().max_element() < 0.01, "{bounds:?}");
        assert!((field.reference(DVec3::new(100_000.1, 0.0, 0.0))).abs() < 1e-11);
    }
}
