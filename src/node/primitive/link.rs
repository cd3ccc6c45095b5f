//! A link of a chain.

use glam::DVec3;

use crate::field::{Aabb, Graph, Node, Slope};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// A link of a chain.
pub const NODE: Spec = Spec {
    key: Key::length(
        "link",
        Required,
        "Link of a chain, upright in the xz plane around the origin: the radius of its bends.",
    ),
    parameters: &[
        Key::length("length", Of("link", 1.0), "The length of its straight parts."),
        Key::length("tube", Of("link", 0.35), "The radius of its wire."),
    ],
    formula: "s − |(|(x, max(|z| − l/2, 0))| − r, y)|",
    example: "link = 0.5",
    build: |build| {
        let (radius, length, tube) = (build.number("link")?, build.number("length")?, build.number("tube")?);
        Ok(upright(build.graph(), radius, length, tube))
    },
    ..Spec::PLAIN
};

/// A link upright in the xz plane.
pub(super) fn upright(graph: &mut Graph, radius: f64, length: f64, tube: f64) -> Node {
    let (x, y, z, zero) = (graph.x(), graph.y(), graph.z(), graph.constant(0.0));
    let along = graph.abs(z);
    let along = graph.linear(along, 1.0, -length / 2.0);
    let along = graph.max(along, zero);
    let across = graph.length(&[x, along]);
    let across = graph.linear(across, 1.0, -radius);
    let away = graph.length(&[across, y]);
    let node = graph.linear(away, -1.0, tube);
    let half = DVec3::new(radius + tube, tube, length / 2.0 + radius + tube);
    let slope = Slope::Exact { outside: true, inside: tube <= radius };
    graph.sloped(node, slope, Some(Aabb::new(-half, half)))
}
