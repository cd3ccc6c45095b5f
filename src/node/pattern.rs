//! Numbers over space as sources of scalars and colours: noise, waves, ramps.

use std::sync::Arc;

use glam::DVec3;

use crate::attribute::{ColourSpace, FieldValue, LinearRgb, Mix, Mixer, Ramp, RampEase, Scalar, ScalarField, Straight};
use crate::field::{Expression, Field, Fold, Fractal, Graph, Near, Node, Noise, NoiseField, Worley};
use crate::node::argument::{Arguments, Component};
use crate::node::keys::{COLOUR_SPACES, seed};
use crate::node::painted::Paint;
use crate::node::source::Sourcing;
use crate::text::key::Absent::{Number, Required, Text, Vector, Words};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// The colours that a number from 0 to 1 goes through.
pub(crate) const COLOURS: Key =
    Key::new("colors", Kind::Palette, Required, "The colours from 0 to 1, evenly: a palette's name, or at least one.")
        .also(&["colours"]);

/// The space that they are mixed in.
pub(crate) const SPACE: Key =
    Key::new("color_space", Kind::Choice(COLOUR_SPACES), Text("oklab"), "The space that they are mixed in.")
        .also(&["colour_space"]);

/// How one becomes the next.
pub(crate) const EASE: Key = Key::new(
    "ease",
    Kind::Choice(&["linear", "smooth", "hold"]),
    Text("linear"),
    "How each becomes the next: evenly, from rest to rest, or at once where the next is.",
);

/// What 0 and 1 become.
pub(crate) const BETWEEN: Key =
    Key::new("between", Kind::TwoNumbers, Words("`[0, 1]`"), "The numbers that 0 and 1 become.");

/// What noise starts from.
pub(crate) const SEED: Key = seed("The number that it starts from.");

/// How many octaves.
pub(crate) const OCTAVES: Key = Key::new(
    "octaves",
    Kind::Whole,
    Number(4.0),
    "How many are summed, each half as large and as strong as the one before.",
)
.limit(Limit::Within(1.0, 16.0));

/// Which distance of cellular noise.
pub(crate) const NEAR: Key = Key::new(
    "distance",
    Kind::Choice(&["first", "second", "edge"]),
    Text("first"),
    "That of the nearest point, of the second nearest, or how much farther the second is.",
);

/// Where something goes.
pub(crate) const DIRECTION: Key =
    Key::new("direction", Kind::Direction, Vector([1.0, 0.0, 0.0]), "The direction that it goes in.");

/// The size of cells.
pub(crate) const fn size(name: &'static str, text: &'static str) -> Key {
    Key::new(name, Kind::Constant, Required, text).limit(Limit::Positive).unit("units")
}

/// What makes the number, from the values of a row's keys; `main` is the row's own.
pub(crate) type Making = fn(&Arguments, &mut Graph, main: &str) -> Node;

pub(crate) fn constant(arguments: &Arguments, key: &str) -> f64 {
    arguments.constant(key).copied().expect("it has a default")
}

/// Where a place is, in cells of a size.
pub(crate) fn cells(graph: &mut Graph, size: f64) -> [Node; 3] {
    DVec3::AXES.map(|axis| graph.affine(axis * (1.0 / size), 0.0))
}

/// Noise in cells of a row's size.
pub(crate) fn noise<N: Noise + 'static>(
    arguments: &Arguments,
    graph: &mut Graph,
    main: &str,
    make: impl FnOnce(u64) -> N,
) -> Node {
    let at = cells(graph, constant(arguments, main));
    let seed = *arguments.seed("seed").expect("it has a default");
    graph.field_at(Arc::new(NoiseField(make(seed))), at)
}

/// A sum of octaves.
pub(crate) fn fractal(arguments: &Arguments, graph: &mut Graph, main: &str, fold: Fold) -> Node {
    let octaves = arguments.whole("octaves").map_or(1, |octaves| *octaves as u32);
    noise(arguments, graph, main, |seed| Fractal { seed, octaves, fold })
}

/// Cellular noise.
pub(crate) fn worley(arguments: &Arguments, graph: &mut Graph, main: &str) -> Node {
    let near = match arguments.choice("distance") {
        Some(&"second") => Near::Second,
        Some(&"edge") => Near::Edge,
        _ => Near::First,
    };
    noise(arguments, graph, main, |seed| Worley { seed, near })
}

/// The distance from the origin or the z axis, in lengths of a row's size.
pub(crate) fn radius(arguments: &Arguments, graph: &mut Graph, main: &str) -> Node {
    let [x, y, z] = cells(graph, constant(arguments, main));
    if arguments.choice("from") == Some(&"axis") { graph.length(&[x, y]) } else { graph.length(&[x, y, z]) }
}

/// The share of a turn about an axis.
pub(crate) fn angle(arguments: &Arguments, graph: &mut Graph, main: &str) -> Node {
    let axis = ["x", "y", "z"].iter().position(|axis| arguments.choice(main) == Some(axis)).unwrap_or(2);
    let [a, b] = [1, 2].map(|next| graph.affine(DVec3::AXES[(axis + next) % 3], 0.0));
    let angle = graph.atan2(b, a);
    let turns = graph.linear(angle, std::f64::consts::TAU.recip(), 0.0);
    let whole = graph.floor(turns);
    graph.sub(turns, whole)
}

/// How far along a direction, in lengths of a row's size.
pub(crate) fn along(arguments: &Arguments, graph: &mut Graph, main: &str) -> Node {
    let direction = direction(arguments).unwrap_or(DVec3::X);
    graph.affine(direction / constant(arguments, main), 0.0)
}

/// The direction of a row that has one, of length 1; `None` where it moves or has no length.
fn direction(arguments: &Arguments) -> Option<DVec3> {
    let [x, y, z] = arguments.vector("direction").map_or([Some(1.0), Some(0.0), Some(0.0)], |vector| {
        vector.each_ref().map(crate::text::number::Number::as_constant)
    });
    DVec3::new(x?, y?, z?).try_normalize()
}

/// The direction of a key, of length 1.
pub(crate) fn direction_of<const N: usize>(source: &dyn Sourcing<N>, key: &str) -> Result<DVec3, Problem> {
    let constant = |number: &crate::text::number::Number| number.as_constant();
    let parts = source.arguments().vector(key).map(|vector| vector.each_ref().map(constant));
    let direction = match parts {
        Some([Some(x), Some(y), Some(z)]) => DVec3::new(x, y, z).try_normalize(),
        _ => None,
    };
    direction
        .ok_or_else(|| source.problem(&format!("`{key}` must be three numbers that stand still, not all of them 0")))
}

/// The problem of a direction that is none.
fn check_direction<const N: usize>(source: &dyn Sourcing<N>) -> Result<(), Problem> {
    match direction(source.arguments()) {
        Some(_) => Ok(()),
        None => Err(source.problem("`direction` must be three numbers that stand still, not all of them 0")),
    }
}

/// Waves along a direction: 0 at the origin, 1 half a length on.
pub(crate) fn waves(arguments: &Arguments, graph: &mut Graph, main: &str) -> Node {
    let far = along(arguments, graph, main);
    let angle = graph.linear(far, std::f64::consts::TAU, 0.0);
    let cosine = graph.cos(angle);
    graph.linear(cosine, -0.5, 0.5)
}

/// The share of a period of so many stripes along a direction.
pub(crate) fn stripes(arguments: &Arguments, graph: &mut Graph, main: &str, count: usize) -> Node {
    let far = along(arguments, graph, main);
    // The origin is in the middle of the first.
    let periods = graph.linear(far, 1.0 / count as f64, 0.5 / count as f64);
    let whole = graph.floor(periods);
    graph.sub(periods, whole)
}

/// A scalar that is a number over space.
pub(crate) fn number(source: &mut dyn Sourcing<1>, main: &str, making: Making) -> Result<Paint<1>, Problem> {
    let mut graph = Graph::new();
    let node = making(source.arguments(), &mut graph, main);
    number_by(source, graph, node)
}

/// The same of a node of a graph.
pub(crate) fn number_by(source: &dyn Sourcing<1>, mut graph: Graph, node: Node) -> Result<Paint<1>, Problem> {
    check_direction(source)?;
    let node = match source.arguments().values("between").map(|ends| &ends[..]) {
        Some([from, to]) => graph.linear(node, f64::from(to - from), f64::from(*from)),
        _ => node,
    };
    Ok(Paint::shared(Arc::new(FieldValue(field(&graph, node)))))
}

/// A colour by a number over space.
pub(crate) fn colour(source: &mut dyn Sourcing<3>, main: &str, making: Making) -> Result<Paint<3>, Problem> {
    let mut graph = Graph::new();
    let node = making(source.arguments(), &mut graph, main);
    colour_by(source, graph, node)
}

/// The same of a node of a graph.
pub(crate) fn colour_by(source: &dyn Sourcing<3>, graph: Graph, node: Node) -> Result<Paint<3>, Problem> {
    check_direction(source)?;
    Ok(evenly(source.arguments(), field(&graph, node), [0.0, 1.0]))
}

fn field(graph: &Graph, node: Node) -> Arc<dyn Field> {
    Arc::new(Expression::new(graph, node).keeping_values())
}

/// A colour by a scalar, from the number of the first colour to that of the last. `step`: over what its slope is taken.
pub(crate) fn colour_from(source: &dyn Sourcing<3>, scalar: Arc<Scalar>, ends: [f64; 2], step: f64) -> Paint<3> {
    evenly(source.arguments(), Arc::new(ScalarField { scalar, most: f64::INFINITY, step }), ends)
}

/// The colours of a row, even between two numbers.
fn evenly(arguments: &Arguments, by: Arc<dyn Field>, [from, to]: [f64; 2]) -> Paint<3> {
    let colours = arguments.colours("colors").cloned().unwrap_or_default();
    let last = colours.len().saturating_sub(1).max(1) as f64;
    let at = |i: usize| from + (to - from) * i as f64 / last;
    let stops = colours.iter().enumerate().map(|(i, colour)| (at(i), *colour)).collect();
    Paint::of(coloured(arguments, by, stops))
}

fn ease(arguments: &Arguments) -> RampEase {
    match arguments.choice("ease") {
        Some(&"smooth") => RampEase::Smooth,
        Some(&"hold") => RampEase::Hold,
        _ => RampEase::Linear,
    }
}

fn coloured(arguments: &Arguments, by: Arc<dyn Field>, stops: Vec<(f64, LinearRgb)>) -> Ramp<3, Mixer> {
    let space = arguments.choice("color_space").and_then(|name| ColourSpace::named(name)).unwrap_or(ColourSpace::Oklab);
    let mixes = stops.array_windows().map(|[(_, from), (_, to)]| Mixer::between(space, *from, *to)).collect();
    Ramp { by, stops, mixes, ease: ease(arguments) }
}

/// Colours of equal width, over and over.
pub(crate) fn striped<const N: usize, M: Mix<N> + 'static>(
    source: &mut dyn Sourcing<N>,
    main: &str,
    values: Vec<[f32; N]>,
    mix: M,
) -> Result<Paint<N>, Problem> {
    check_direction(source)?;
    let arguments = source.arguments();
    let count = values.len().max(1);
    let mut graph = Graph::new();
    let node = stripes(arguments, &mut graph, main, count);
    let by = field(&graph, node);
    let stops: Vec<(f64, [f32; N])> =
        values.into_iter().enumerate().map(|(i, value)| (i as f64 / count as f64, value)).collect();
    let mixes = vec![mix; count - 1];
    Ok(Paint::of(Ramp { by, stops, mixes, ease: RampEase::Hold }))
}

/// What a ramp's number is read from.
fn by<const N: usize>(source: &mut dyn Sourcing<N>) -> Result<Arc<dyn Field>, Problem> {
    let formula = source.arguments().formula("by").expect("it must be there").clone();
    source.component(&Component::Formula(formula))
}

/// Colours at stops of a formula.
pub(crate) fn colour_ramp(source: &mut dyn Sourcing<3>) -> Result<Paint<3>, Problem> {
    let by = by(source)?;
    let arguments = source.arguments();
    let stops = arguments.bands("ramp").cloned().unwrap_or_default();
    Ok(Paint::of(coloured(arguments, by, stops)))
}

/// Numbers at stops of a formula.
pub(crate) fn number_ramp(source: &mut dyn Sourcing<1>) -> Result<Paint<1>, Problem> {
    let by = by(source)?;
    let arguments = source.arguments();
    let stops = arguments.number_bands("ramp").cloned().unwrap_or_default();
    let mixes = vec![Straight; stops.len().saturating_sub(1)];
    Ok(Paint::of(Ramp { by, stops, mixes, ease: ease(arguments) }))
}

/// The number that a ramp goes by.
pub(crate) const BY: Key = Key::new(
    "by",
    Kind::Formula,
    Required,
    "The number that it goes by: a formula of x, y, z in the shape's own space, and of time.",
);
