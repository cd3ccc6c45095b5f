//! The functions that formulas know.

use crate::field::graph::{Graph, Node};
use crate::field::op::{Binary, Unary};

/// A function of formulas.
#[derive(Clone, Copy, Debug)]
pub(super) struct Function {
    name: &'static str,
    /// How many arguments it takes at least and at most.
    pub least: usize,
    pub most: usize,
    make: fn(&mut Graph, &[Node]) -> Node,
}

/// The names of all functions.
pub const FUNCTIONS: [&str; 27] = {
    let mut names = [""; 27];
    let mut i = 0;
    while i < names.len() {
        names[i] = TABLE[i].name;
        i += 1;
    }
    names
};

const fn function(name: &'static str, arguments: usize, make: fn(&mut Graph, &[Node]) -> Node) -> Function {
    Function { name, least: arguments, most: arguments, make }
}

const fn any_number(name: &'static str, make: fn(&mut Graph, &[Node]) -> Node) -> Function {
    Function { name, least: 1, most: usize::MAX, make }
}

const TABLE: [Function; 27] = [
    function("abs", 1, |graph, a| graph.abs(a[0])),
    function("atan", 1, |graph, a| {
        let one = graph.constant(1.0);
        graph.binary(Binary::Atan2, a[0], one)
    }),
    function("atan2", 2, |graph, a| graph.binary(Binary::Atan2, a[0], a[1])),
    function("cbrt", 1, |graph, a| graph.unary(Unary::Cbrt, a[0])),
    function("ceil", 1, |graph, a| {
        let turned = graph.neg(a[0]);
        let floor = graph.unary(Unary::Floor, turned);
        graph.neg(floor)
    }),
    function("clamp", 3, |graph, a| {
        let raised = graph.max(a[0], a[1]);
        graph.min(raised, a[2])
    }),
    function("cos", 1, |graph, a| graph.unary(Unary::Cos, a[0])),
    function("exp", 1, |graph, a| graph.unary(Unary::Exp, a[0])),
    function("floor", 1, |graph, a| graph.unary(Unary::Floor, a[0])),
    function("fract", 1, |graph, a| {
        let floor = graph.unary(Unary::Floor, a[0]);
        graph.sub(a[0], floor)
    }),
    any_number("length", |graph, a| graph.length(a)),
    function("ln", 1, |graph, a| graph.unary(Unary::Log, a[0])),
    function("log", 1, |graph, a| graph.unary(Unary::Log, a[0])),
    any_number("max", |graph, a| fold(graph, Binary::Max, a)),
    any_number("min", |graph, a| fold(graph, Binary::Min, a)),
    function("mix", 3, |graph, a| {
        let span = graph.sub(a[1], a[0]);
        let part = graph.mul(span, a[2]);
        graph.add(a[0], part)
    }),
    function("mod", 2, |graph, a| {
        let quotient = graph.div(a[0], a[1]);
        let whole = graph.unary(Unary::Floor, quotient);
        let taken = graph.mul(a[1], whole);
        graph.sub(a[0], taken)
    }),
    function("pow", 2, |graph, a| graph.binary(Binary::Pow, a[0], a[1])),
    function("round", 1, |graph, a| {
        let shifted = graph.linear(a[0], 1.0, 0.5);
        graph.unary(Unary::Floor, shifted)
    }),
    function("sign", 1, |graph, a| graph.unary(Unary::Sign, a[0])),
    function("sin", 1, |graph, a| graph.unary(Unary::Sin, a[0])),
    function("smoothstep", 3, |graph, a| {
        let (past, span) = (graph.sub(a[2], a[0]), graph.sub(a[1], a[0]));
        let share = graph.div(past, span);
        graph.unary(Unary::Smooth, share)
    }),
    function("sqrt", 1, |graph, a| graph.sqrt(a[0])),
    // 0 below the edge, 1 from it on: ½ + ½·sign, but 1 at the edge itself.
    function("step", 2, |graph, a| {
        let short = graph.sub(a[0], a[1]);
        let sign = graph.unary(Unary::Sign, short);
        let zero = graph.constant(0.0);
        let below = graph.max(sign, zero);
        graph.linear(below, -1.0, 1.0)
    }),
    function("tan", 1, |graph, a| {
        let (sine, cosine) = (graph.unary(Unary::Sin, a[0]), graph.unary(Unary::Cos, a[0]));
        graph.div(sine, cosine)
    }),
    // 1 − 2/(e²ˣ + 1) names x once, so that its bounds are tight.
    function("tanh", 1, |graph, a| {
        let doubled = graph.linear(a[0], 2.0, 0.0);
        let power = graph.unary(Unary::Exp, doubled);
        let grown = graph.linear(power, 1.0, 1.0);
        let inverse = graph.unary(Unary::Recip, grown);
        graph.linear(inverse, -2.0, 1.0)
    }),
    // The union of two fields that an operation names: system R₀.
    function("union", 2, |graph, a| graph.binary(Binary::Union, a[0], a[1])),
];

fn fold(graph: &mut Graph, operation: Binary, arguments: &[Node]) -> Node {
    arguments[1..].iter().fold(arguments[0], |folded, &next| graph.binary(operation, folded, next))
}

impl Function {
    pub fn named(name: &str) -> Option<Self> {
        TABLE.into_iter().find(|function| function.name == name)
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
