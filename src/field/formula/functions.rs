//! The functions that formulas know.

use std::sync::Arc;

use crate::field::graph::{Graph, Node};
use crate::field::noise::{Fold, Fractal, GradientNoise, Near, Noise, NoiseField, Simplex, ValueNoise, Worley};
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

const fn up_to_one_more(
    name: &'static str,
    least: usize,
    usage: &'static str,
    text: &'static str,
    make: Make,
) -> Function {
    Function { name, least, most: least + 1, usage, text, make }
}

/// Noise read at three arguments; the seed is the one after those and `more`.
fn noise<N: Noise + 'static>(graph: &mut Graph, a: &[Node], seed: usize, make: impl FnOnce(u64) -> N) -> Node {
    match whole(graph, a.get(seed)) {
        Some(seed) => graph.field_at(Arc::new(NoiseField(make(seed))), [a[0], a[1], a[2]]),
        None => graph.constant(f64::NAN),
    }
}

/// The whole number that an argument is everywhere, 0 where it is left out; `None` where it differs from place to place.
fn whole(graph: &Graph, argument: Option<&Node>) -> Option<u64> {
    argument.map_or(Some(0), |node| graph.as_constant(*node).map(|number| number.round().max(0.0) as u64))
}

/// A sum of octaves of noise; how many is the argument after the place.
fn fractal(graph: &mut Graph, a: &[Node], fold: Fold) -> Node {
    match whole(graph, a.get(3)) {
        Some(octaves) => noise(graph, a, 4, |seed| Fractal { seed, octaves: octaves.min(64) as u32, fold }),
        None => graph.constant(f64::NAN),
    }
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
    function(
        "if",
        3,
        "if(condition, then, else)",
        "the second where the first is not 0, else the third, whatever the one that is not taken is there; jumps where they \
         differ. Conditions are comparisons; `(a)*(b)` is both, `max(a, b)` either",
        |graph, a| graph.choose(a[0], a[1], a[2]),
    ),
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
    up_to_one_more(
        "fbm",
        4,
        "fbm(x, y, z, octaves[, seed])",
        "sum of octaves of gradient noise, each half as large and as strong as the one before; from 0 to 1",
        |graph, a| fractal(graph, a, Fold::Plain),
    ),
    up_to_one_more(
        "gradient_noise",
        3,
        "gradient_noise(x, y, z[, seed])",
        "Perlin noise in cells of edge 1, from 0 to 1",
        |graph, a| noise(graph, a, 3, |seed| GradientNoise { seed }),
    ),
    up_to_one_more(
        "noise",
        3,
        "noise(x, y, z[, seed])",
        "value noise in cells of edge 1, from 0 to 1; the same on every machine, as all noise here. A seed is a whole number \
         and the same everywhere",
        |graph, a| noise(graph, a, 3, |seed| ValueNoise { seed }),
    ),
    up_to_one_more(
        "ridged",
        4,
        "ridged(x, y, z, octaves[, seed])",
        "as fbm, of noise folded to crests, from 0 to 1",
        |graph, a| fractal(graph, a, Fold::Ridged),
    ),
    up_to_one_more(
        "simplex",
        3,
        "simplex(x, y, z[, seed])",
        "simplex noise, from 0 to 1: no direction shows",
        |graph, a| noise(graph, a, 3, |seed| Simplex { seed }),
    ),
    up_to_one_more(
        "turbulence",
        4,
        "turbulence(x, y, z, octaves[, seed])",
        "as fbm, of noise folded to valleys, from 0 to 1",
        |graph, a| fractal(graph, a, Fold::Turbulence),
    ),
    up_to_one_more(
        "worley_edge",
        3,
        "worley_edge(x, y, z[, seed])",
        "worley_f2 − worley_f1, both by the same scale: 0 on the walls between points, below 1",
        |graph, a| noise(graph, a, 3, |seed| Worley { seed, near: Near::Edge }),
    ),
    up_to_one_more(
        "worley_f1",
        3,
        "worley_f1(x, y, z[, seed])",
        "distance of the nearest of points scattered one a cell, over the greatest there can be (1.559); from 0 to 1",
        |graph, a| noise(graph, a, 3, |seed| Worley { seed, near: Near::First }),
    ),
    up_to_one_more(
        "worley_f2",
        3,
        "worley_f2(x, y, z[, seed])",
        "distance of the second nearest, over the greatest there can be (1.892); from 0 to 1",
        |graph, a| noise(graph, a, 3, |seed| Worley { seed, near: Near::Second }),
    ),
    function(
        "angle",
        2,
        "angle(x, y)",
        "the direction (x, y) as a share of a whole turn from the x axis, counterclockwise, from 0 to below 1; jumps there",
        |graph, a| {
            let angle = graph.binary(Binary::Atan2, a[1], a[0]);
            let turns = graph.linear(angle, std::f64::consts::TAU.recip(), 0.0);
            let whole = graph.unary(Unary::Floor, turns);
            graph.sub(turns, whole)
        },
    ),
    function("wave", 1, "wave(x)", "½ − ½·cos(2πx): 0 at whole numbers, 1 between them", |graph, a| {
        let angle = graph.linear(a[0], std::f64::consts::TAU, 0.0);
        let cosine = graph.unary(Unary::Cos, angle);
        graph.linear(cosine, -0.5, 0.5)
    }),
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
            (least, most) if most == least + 1 => format!("{least} or {most} arguments"),
            (1, usize::MAX) => "one argument or more".to_owned(),
            (1, 1) => "one argument".to_owned(),
            (least, _) => format!("{least} arguments"),
        }
    }
}
