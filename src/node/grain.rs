//! Wood and marble: rings and veins that noise bends.

use crate::field::{Field, Fold, Fractal, Graph, Node, Noise, NoiseField, ValueNoise};
use crate::node::argument::{Arguments, Component};
use crate::node::painted::Paint;
use crate::node::pattern::{along, cells, colour_by, constant, number_by};
use crate::node::source::Sourcing;
use crate::text::key::Absent::{Nothing, Number, Text};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

use std::sync::Arc;

/// What rings or veins follow instead of a place.
pub(crate) const BY: Key = Key::new(
    "by",
    Kind::Formula,
    Nothing,
    "What they follow instead, units: a formula of x, y, z in the shape's own space and of its attributes, such as its depth.",
);

/// How far noise bends them.
pub(crate) const WARP: Key = Key::new(
    "warp",
    Kind::Constant,
    Number(1.0),
    "How far noise moves them, as a share of their distance: from this far inward to as far outward.",
)
.limit(Limit::NotNegative);

/// How large the bends are.
pub(crate) const GRAIN: Key = Key::new(
    "grain",
    Kind::Constant,
    Nothing,
    "The size of the cells of noise that moves them; left out, four times their distance.",
)
.limit(Limit::Positive)
.unit("units");

/// What rings of wood are around.
pub(crate) const AXIS: Key =
    Key::new("axis", Kind::Choice(&["x", "y", "z"]), Text("z"), "The axis that rings are around.");

/// How soon a ring begins anew.
pub(crate) const EDGE: Key =
    Key::new("edge", Kind::Constant, Number(0.2), "The share of a ring over which it goes back from 1 to 0.")
        .limit(Limit::Within(0.0, 1.0));

/// A row's number, from that which it follows, in periods, the width of a voxel in the same, and its keys.
type Grain = fn(&Arguments, &mut Graph, Node, f64) -> Node;

/// Less than this share of a period is no filter: differences of sums over it would be rounding alone.
const LEAST_WIDTH: f64 = 1e-3;

/// Wood: 0 to 1 outward through each ring, and back.
///
/// HFRep, section 7 and equation 25, with the whole part ⌊·⌋ and not int(·), which differ below 0; the way from an axis moved
/// by noise, not noise of a product with the distance, which is one number all over the surface.
pub(crate) fn wood(arguments: &Arguments, graph: &mut Graph, periods: Node, width: f64) -> Node {
    let edge = constant(arguments, "edge").max(LEAST_WIDTH);
    let rise = 1.0 - edge;
    // The mean over a voxel: the integral from one side to the other. That of a whole ring is 1/2.
    let half = 0.5 * width.max(LEAST_WIDTH);
    let mut integral = |by: f64| {
        let at = graph.offset(periods, by);
        let whole = graph.floor(at);
        let within = graph.sub(at, whole);
        let (zero, turn) = (graph.constant(0.0), graph.constant(rise));
        let (up, past) = (graph.min(within, turn), graph.offset(within, -rise));
        let down = graph.max(past, zero);
        let (rising, falling) = (graph.mul(up, up), graph.mul(down, down));
        let rising = graph.linear(rising, if rise > 0.0 { 0.5 / rise } else { 0.0 }, 0.0);
        let falling = graph.linear(falling, -0.5 / edge, 0.0);
        let falling = graph.add(down, falling);
        (whole, graph.add(rising, falling))
    };
    let ((from, least), (to, most)) = (integral(-half), integral(half));
    let (rings, part) = (graph.sub(to, from), graph.sub(most, least));
    let rings = graph.linear(rings, 0.5, 0.0);
    let sum = graph.add(rings, part);
    graph.linear(sum, 0.5 / half, 0.0)
}

/// Marble: 0, 1 and 0 again from vein to vein.
pub(crate) fn marble(_: &Arguments, graph: &mut Graph, periods: Node, width: f64) -> Node {
    let angle = graph.linear(periods, std::f64::consts::TAU, 0.0);
    let cosine = graph.cos(angle);
    // The mean of a wave over a voxel: sin(πw)/(πw) of it.
    let phase = std::f64::consts::PI * width;
    let rest = if phase > 1e-6 { libm::sin(phase) / phase } else { 1.0 };
    graph.linear(cosine, -0.5 * if width < 1.0 { rest } else { 0.0 }, 0.5)
}

/// What a row follows, in periods, moved by noise.
fn periods<const N: usize>(source: &mut dyn Sourcing<N>, main: &str, graph: &mut Graph) -> Result<Node, Problem> {
    let by = match source.arguments().formula("by").cloned() {
        Some(formula) => Some(source.component(&Component::Formula(formula))?),
        None => None,
    };
    let arguments = source.arguments();
    let spacing = constant(arguments, main);
    let far = match (by, arguments.choice("axis")) {
        (Some(by), _) => {
            let value = graph.field(by);
            graph.linear(value, 1.0 / spacing, 0.0)
        }
        (None, Some(axis)) => {
            let mut across = cells(graph, spacing).to_vec();
            across.remove(["x", "y", "z"].iter().position(|name| name == axis).unwrap_or(2));
            graph.length(&across)
        }
        (None, None) => along(arguments, graph, main),
    };
    let warp = constant(arguments, "warp");
    if warp == 0.0 {
        return Ok(far);
    }
    let size = arguments.constant("grain").copied().unwrap_or(4.0 * spacing);
    let at = cells(graph, size);
    let seed = *arguments.seed("seed").expect("it has a default");
    let noise: Arc<dyn Field> = match arguments.whole("octaves") {
        Some(octaves) => shared(Fractal { seed, octaves: *octaves as u32, fold: Fold::Plain }),
        None => shared(ValueNoise { seed }),
    };
    let noise = graph.field_at(noise, at);
    let moved = graph.linear(noise, 2.0 * warp, -warp);
    Ok(graph.add(far, moved))
}

fn shared(noise: impl Noise + 'static) -> Arc<dyn Field> {
    Arc::new(NoiseField(noise))
}

fn node<const N: usize>(
    source: &mut dyn Sourcing<N>,
    main: &str,
    graph: &mut Graph,
    grain: Grain,
) -> Result<Node, Problem> {
    let periods = periods(source, main, graph)?;
    let width = source.voxel() / constant(source.arguments(), main);
    Ok(grain(source.arguments(), graph, periods, width))
}

/// A colour by a grain.
pub(crate) fn colour(source: &mut dyn Sourcing<3>, main: &str, grain: Grain) -> Result<Paint<3>, Problem> {
    let mut graph = Graph::new();
    let node = node(source, main, &mut graph, grain)?;
    colour_by(source, graph, node)
}

/// A number by a grain.
pub(crate) fn number(source: &mut dyn Sourcing<1>, main: &str, grain: Grain) -> Result<Paint<1>, Problem> {
    let mut graph = Graph::new();
    let node = node(source, main, &mut graph, grain)?;
    number_by(source, graph, node)
}
