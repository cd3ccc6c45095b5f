//! The functions that formulas know.

use crate::field::graph::{Graph, Node};
use crate::field::op::{self, Binary, Unary};

/// A function of formulas.
#[derive(Clone, Copy, Debug)]
pub(in crate::field) struct Function {
    name: &'static str,
    /// How many arguments it takes at least and at most.
    pub least: usize,
    pub most: usize,
    /// How it is called, with names for its arguments.
    pub usage: &'static str,
    /// What it gives.
    text: &'static str,
    make: Make,
}

/// All functions by name: that, how each is called, and what it gives.
pub fn functions() -> impl Iterator<Item = (&'static str, &'static str, &'static str)> {
    let mut all: Vec<_> = table().map(|function| (function.name, function.usage, function.text)).collect();
    all.sort_unstable();
    all.into_iter()
}

fn table() -> impl Iterator<Item = &'static Function> {
    MADE.iter().chain(op::functions())
}

type Make = fn(&mut Graph, &[Node]) -> Node;

pub(in crate::field) const fn function(
    name: &'static str,
    arguments: usize,
    usage: &'static str,
    text: &'static str,
    make: Make,
) -> Function {
    Function { name, least: arguments, most: arguments, usage, text, make }
}

pub(in crate::field) const fn any_number(
    name: &'static str,
    usage: &'static str,
    text: &'static str,
    make: Make,
) -> Function {
    Function { name, least: 1, most: usize::MAX, usage, text, make }
}

/// Functions made of several operations; those of one stand with it, in [`op`].
const MADE: &[Function] = &[
    function("ceil", 1, "ceil(x)", "the least whole number that is not below x; jumps", |graph, a| {
        let turned = graph.neg(a[0]);
        let floor = graph.unary(Unary::Floor, turned);
        graph.neg(floor)
    }),
    function("clamp", 3, "clamp(x, least, greatest)", "x held between the two", |graph, a| {
        let raised = graph.max(a[0], a[1]);
        graph.min(raised, a[2])
    }),
    function("fract", 1, "fract(x)", "x − floor(x), from 0 to below 1; jumps", |graph, a| {
        let floor = graph.unary(Unary::Floor, a[0]);
        graph.sub(a[0], floor)
    }),
    any_number("length", "length(x, y, …)", "√(x² + y² + …), of one number or more", |graph, a| {
        graph.length(a)
    }),
    function(
        "mix",
        3,
        "mix(a, b, share)",
        "a + (b − a)·share; a share below 0 or above 1 goes beyond them",
        |graph, a| {
            let span = graph.sub(a[1], a[0]);
            let part = graph.mul(span, a[2]);
            graph.add(a[0], part)
        },
    ),
    function(
        "mod",
        2,
        "mod(x, y)",
        "x − y·floor(x/y): from 0 to below y where y is positive, whatever the sign of x; jumps",
        |graph, a| {
            let quotient = graph.div(a[0], a[1]);
            let whole = graph.unary(Unary::Floor, quotient);
            let taken = graph.mul(a[1], whole);
            graph.sub(a[0], taken)
        },
    ),
    function("round", 1, "round(x)", "the nearest whole number, halves upward: floor(x + ½); jumps", |graph, a| {
        let shifted = graph.linear(a[0], 1.0, 0.5);
        graph.unary(Unary::Floor, shifted)
    }),
    function(
        "smoothstep",
        3,
        "smoothstep(from, to, x)",
        "0 up to `from`, 1 after `to`, 3s² − 2s³ between them; the two must differ",
        |graph, a| {
            let (past, span) = (graph.sub(a[2], a[0]), graph.sub(a[1], a[0]));
            let share = graph.div(past, span);
            graph.unary(Unary::Smooth, share)
        },
    ),
    // 0 below the edge, 1 from it on: ½ + ½·sign, but 1 at the edge itself.
    function("step", 2, "step(edge, x)", "0 where x is below the edge, else 1; jumps", |graph, a| {
        let short = graph.sub(a[0], a[1]);
        let sign = graph.unary(Unary::Sign, short);
        let zero = graph.constant(0.0);
        let below = graph.max(sign, zero);
        graph.linear(below, -1.0, 1.0)
    }),
    function("tan", 1, "tan(x)", "the tangent of an angle in radians", |graph, a| {
        let (sine, cosine) = (graph.unary(Unary::Sin, a[0]), graph.unary(Unary::Cos, a[0]));
        graph.div(sine, cosine)
    }),
    // 1 − 2/(e²ˣ + 1) names x once, so that its bounds are tight.
    function("tanh", 1, "tanh(x)", "the hyperbolic tangent, from −1 to 1", |graph, a| {
        let doubled = graph.linear(a[0], 2.0, 0.0);
        let power = graph.unary(Unary::Exp, doubled);
        let grown = graph.linear(power, 1.0, 1.0);
        let inverse = graph.unary(Unary::Recip, grown);
        graph.linear(inverse, -2.0, 1.0)
    }),
];

pub(in crate::field) fn fold(graph: &mut Graph, operation: Binary, arguments: &[Node]) -> Node {
    arguments[1..].iter().fold(arguments[0], |folded, &next| graph.binary(operation, folded, next))
}

impl Function {
    pub fn named(name: &str) -> Option<Self> {
        table().find(|function| function.name == name).copied()
    }

    pub fn build(&self, graph: &mut Graph, arguments: &[Node]) -> Node {
        (self.make)(graph, arguments)
    }

    /// What it wants, in words.
    pub fn arity(&self) -> String {
        match (self.least, self.most) {
            (1, usize::MAX) => "one argument or more".to_owned(),
            (1, 1) => "one argument".to_owned(),
            (least, _) => format!("{least} arguments"),
        }
    }
}
