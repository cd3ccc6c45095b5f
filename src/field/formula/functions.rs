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
    /// How it is called, with names for its arguments.
    pub usage: &'static str,
    /// What it gives.
    text: &'static str,
    make: Make,
}

/// All functions: name, how it is called, and what it gives.
pub fn functions() -> impl Iterator<Item = (&'static str, &'static str, &'static str)> {
    TABLE.iter().map(|function| (function.name, function.usage, function.text))
}

type Make = fn(&mut Graph, &[Node]) -> Node;

const fn function(
    name: &'static str,
    arguments: usize,
    usage: &'static str,
    text: &'static str,
    make: Make,
) -> Function {
    Function { name, least: arguments, most: arguments, usage, text, make }
}

const fn any_number(name: &'static str, usage: &'static str, text: &'static str, make: Make) -> Function {
    Function { name, least: 1, most: usize::MAX, usage, text, make }
}

const TABLE: [Function; 27] = [
    function("abs", 1, "abs(x)", "x without its sign", |graph, a| graph.abs(a[0])),
    function("atan", 1, "atan(x)", "the angle whose tangent is x, radians, from −π/2 to π/2", |graph, a| {
        let one = graph.constant(1.0);
        graph.binary(Binary::Atan2, a[0], one)
    }),
    function(
        "atan2",
        2,
        "atan2(y, x)",
        "the angle of the direction (x, y) from the x axis, radians, from −π to π; 0 where both are 0",
        |graph, a| graph.binary(Binary::Atan2, a[0], a[1]),
    ),
    function("cbrt", 1, "cbrt(x)", "the cube root, negative where x is", |graph, a| graph.unary(Unary::Cbrt, a[0])),
    function("ceil", 1, "ceil(x)", "the least whole number that is not below x; jumps", |graph, a| {
        let turned = graph.neg(a[0]);
        let floor = graph.unary(Unary::Floor, turned);
        graph.neg(floor)
    }),
    function("clamp", 3, "clamp(x, least, greatest)", "x held between the two", |graph, a| {
        let raised = graph.max(a[0], a[1]);
        graph.min(raised, a[2])
    }),
    function("cos", 1, "cos(x)", "the cosine of an angle in radians", |graph, a| graph.unary(Unary::Cos, a[0])),
    function("exp", 1, "exp(x)", "e to the power of x", |graph, a| graph.unary(Unary::Exp, a[0])),
    function("floor", 1, "floor(x)", "the greatest whole number that is not above x; jumps", |graph, a| {
        graph.unary(Unary::Floor, a[0])
    }),
    function("fract", 1, "fract(x)", "x − floor(x), from 0 to below 1; jumps", |graph, a| {
        let floor = graph.unary(Unary::Floor, a[0]);
        graph.sub(a[0], floor)
    }),
    any_number("length", "length(x, y, …)", "√(x² + y² + …), of one number or more", |graph, a| {
        graph.length(a)
    }),
    function("ln", 1, "ln(x)", "the natural logarithm; of a negative number not a number", |graph, a| {
        graph.unary(Unary::Log, a[0])
    }),
    function("log", 1, "log(x)", "the same as `ln`", |graph, a| graph.unary(Unary::Log, a[0])),
    any_number("max", "max(x, y, …)", "the greatest of one number or more", |graph, a| fold(graph, Binary::Max, a)),
    any_number("min", "min(x, y, …)", "the least of one number or more", |graph, a| fold(graph, Binary::Min, a)),
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
    function(
        "pow",
        2,
        "pow(x, y)",
        "x to the power of y, the same as `x^y`; of a negative x not a number, unless y is written as a whole number",
        |graph, a| graph.binary(Binary::Pow, a[0], a[1]),
    ),
    function("round", 1, "round(x)", "the nearest whole number, halves upward: floor(x + ½); jumps", |graph, a| {
        let shifted = graph.linear(a[0], 1.0, 0.5);
        graph.unary(Unary::Floor, shifted)
    }),
    function("sign", 1, "sign(x)", "−1, 0 or 1; jumps", |graph, a| graph.unary(Unary::Sign, a[0])),
    function("sin", 1, "sin(x)", "the sine of an angle in radians", |graph, a| graph.unary(Unary::Sin, a[0])),
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
    function("sqrt", 1, "sqrt(x)", "the square root; of a negative number not a number", |graph, a| graph.sqrt(a[0])),
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
    // The union of two fields that an operation names: system R₀.
    function(
        "union",
        2,
        "union(f, g)",
        "f + g + √(f² + g²): positive where either is (system R₀), smooth but where both are 0",
        |graph, a| graph.binary(Binary::Union, a[0], a[1]),
    ),
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
