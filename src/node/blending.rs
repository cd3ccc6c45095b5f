//! Set operations that join two surfaces by a shape of their own: each is a function of the two distances.

use crate::field::{Graph, Interval, Kernel, Node};
use crate::node::id::ShapeId;
use crate::node::spec::Build;
use crate::text::key::Absent::{Number, Text};
use crate::text::key::{Key, Kind};
use crate::text::problem::Problem;

/// How far from where two surfaces meet the join reaches.
pub(crate) const BLEND_RADIUS: Key = Key::length(
    "blend_radius",
    Number(0.25),
    "How far from the one surface, along the other, the join begins where both meet at a right angle.",
);

/// Which set operation a join belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Joined {
    Union,
    Intersection,
    Difference,
}

/// Shapes joined one after another. `join` makes the union of two distances, positive inside; the other operations follow by
/// complements.
pub(crate) fn joined(
    build: &mut dyn Build,
    key: &'static str,
    set: Joined,
    join: impl Fn(&mut Graph, Node, Node, f64) -> Node,
) -> Result<Node, Problem> {
    let (radius, most) = (build.number("blend_radius")?, build.ever("blend_radius")?.hi);
    let shapes = build.arguments().shapes(key).cloned().unwrap_or_default();
    // What is added lies outside of both, what is taken away inside.
    let (outside, inside) = (Interval::new(-most, 0.0), Interval::new(0.0, most));
    let mut nodes = Vec::with_capacity(shapes.len());
    for (place, id) in shapes.into_iter().enumerate() {
        let (levels, turned) = match set {
            Joined::Union => (outside, false),
            Joined::Intersection => (inside, true),
            Joined::Difference if place == 0 => (inside, true),
            Joined::Difference => (outside, false),
        };
        let node = build.shape_distance(id, levels, "blend_radius")?;
        nodes.push(if turned { build.graph().neg(node) } else { node });
    }
    let graph = build.graph();
    let node = nodes.iter().copied().reduce(|joined, next| join(graph, joined, next, radius));
    let node = node.unwrap_or_else(|| unreachable!("there are two operands"));
    if set == Joined::Union {
        return Ok(node);
    }
    let node = graph.neg(node);
    // The join takes away from what is in both, or in the first.
    let kept = if set == Joined::Difference { &nodes[..1] } else { &nodes[..] };
    for operand in kept {
        let whole = graph.neg(*operand);
        if let Some(aabb) = graph.known_box(whole) {
            graph.bounded(node, aabb);
        }
    }
    Ok(node)
}

/// The distances of two shapes on both sides, as far as a radius.
pub(crate) fn two_distances(
    build: &mut dyn Build,
    key: &'static str,
    radius: &'static str,
    reach: f64,
) -> Result<[Node; 2], Problem> {
    let shapes: Vec<ShapeId> = build.arguments().shapes(key).cloned().unwrap_or_default();
    let levels = Interval::new(-reach, reach);
    let [a, b] = [0, 1].map(|place| build.shape_distance(shapes[place], levels, radius));
    Ok([a?, b?])
}

/// A node with the box of the union of two solids grown by a distance, where both end.
pub(crate) fn around_both(graph: &mut Graph, node: Node, [a, b]: [Node; 2], by: f64) -> Node {
    match graph.known_box(a).zip(graph.known_box(b)) {
        Some((a, b)) => graph.bounded(node, a.union(b).grown(by)),
        None => node,
    }
}

/// Both no steeper than this, where that is known.
pub(crate) fn steepest(graph: &Graph, nodes: [Node; 2]) -> Option<f64> {
    use crate::field::Slope;
    let of = |node: Node| match graph.slope(node) {
        Slope::Exact { .. } => Some(1.0),
        Slope::Lipschitz(bound) => Some(bound),
        Slope::Unknown => None,
    };
    Some(of(nodes[0])?.max(of(nodes[1])?))
}

/// A fillet: a quarter of a tube in the corner between two surfaces.
pub(crate) fn rounded(graph: &mut Graph, a: Node, b: Node, radius: f64) -> Node {
    let steep = steepest(graph, [a, b]);
    let zero = graph.constant(0.0);
    let [near_a, near_b] = [a, b].map(|node| {
        let near = graph.linear(node, 1.0, radius);
        graph.max(near, zero)
    });
    let far = graph.length(&[near_a, near_b]);
    let least = graph.constant(-radius);
    let base = graph.max(a, b);
    let base = graph.min(base, least);
    let node = graph.add(base, far);
    let node = steep.map_or(node, |bound| graph.no_steeper(node, bound * std::f64::consts::SQRT_2));
    // It reaches no farther than (√2 − 1)·r, where surfaces meet at right angles; r where they touch.
    around_both(graph, node, [a, b], radius)
}

/// A plane across the corner between two surfaces.
pub(crate) fn chamfered(graph: &mut Graph, a: Node, b: Node, radius: f64) -> Node {
    let both = graph.max(a, b);
    let sum = graph.add(a, b);
    let share = std::f64::consts::FRAC_1_SQRT_2;
    let across = graph.linear(sum, share, radius * share);
    let node = graph.max(both, across);
    around_both(graph, node, [a, b], radius)
}

/// Steps in the corner between two surfaces.
pub(crate) fn stepped(graph: &mut Graph, a: Node, b: Node, radius: f64, steps: u32) -> Node {
    let mut node = graph.max(a, b);
    for step in 1..steps {
        let along = radius * f64::from(step) / f64::from(steps);
        let (first, second) = (graph.linear(a, 1.0, along), graph.linear(b, 1.0, radius - along));
        let block = graph.min(first, second);
        node = graph.max(node, block);
    }
    around_both(graph, node, [a, b], radius)
}

/// Columns that stand in the corner between two surfaces, side by side across it.
pub(crate) fn columned(graph: &mut Graph, a: Node, b: Node, radius: f64, columns: u32) -> Node {
    let steep = steepest(graph, [a, b]);
    let mut node = chamfered(graph, a, b, radius);
    let own = radius * std::f64::consts::FRAC_1_SQRT_2 / f64::from(columns);
    for column in 0..columns {
        let along = radius * (f64::from(column) + 0.5) / f64::from(columns);
        let (first, second) = (graph.linear(a, 1.0, along), graph.linear(b, 1.0, radius - along));
        let far = graph.length(&[first, second]);
        let tube = graph.linear(far, -1.0, own);
        let tube = steep.map_or(tube, |bound| graph.no_steeper(tube, bound * std::f64::consts::SQRT_2));
        node = graph.max(node, tube);
    }
    around_both(graph, node, [a, b], radius + own)
}

/// The key of what a smooth join is smooth by.
pub const KERNEL: Key = Key::new(
    "kernel",
    Kind::Choice(&["quadratic", "cubic", "circular", "exponential"]),
    Text("quadratic"),
    "What it is smooth by: polynomials of second and third degree, a piece of a circle, or exponentials, which are felt \
     everywhere.",
);

/// The kernel of a smooth join.
pub fn kernel(build: &dyn Build) -> Kernel {
    match build.arguments().choice("kernel") {
        Some(&"cubic") => Kernel::Cubic,
        Some(&"circular") => Kernel::Circular,
        Some(&"exponential") => Kernel::Exponential,
        _ => Kernel::Quadratic,
    }
}
