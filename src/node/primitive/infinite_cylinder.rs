//! An infinite cylinder.

use crate::field::Slope;
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// An infinite cylinder.
pub const NODE: Spec = Spec {
    key: Key::length(
        "infinite_cylinder",
        Required,
        "Infinite cylinder around the z axis: its radius. Unbounded; use it to cut.",
    ),
    formula: "r − |(x, y)|",
    example: "infinite_cylinder = 0.5\nbounds = 2",
    is_endless: true,
    build: |build| {
        let radius = build.number("infinite_cylinder")?;
        let graph = build.graph();
        let across = graph.radius_about_z();
        let node = graph.linear(across, -1.0, radius);
        Ok(graph.sloped(node, Slope::Exact { outside: true, inside: true }, None))
    },
    ..Spec::PLAIN
};
