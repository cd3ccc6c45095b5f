//! The space behind two or three planes at right angles.

use glam::DVec3;

use crate::field::{Node, Slope};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// The space behind two or three planes at right angles.
pub const NODE: Spec = Spec {
    key: Key::new(
        "corner",
        Kind::Choice(&["xy", "xz", "yz", "xyz"]),
        Required,
        "All where these coordinates are at most 0: the space behind two or three planes at right angles. Unbounded; use it to cut.",
    ),
    formula: "min(−x, −y, −z) inside, minus the distance to it outside",
    example: "corner = \"xyz\"\nbounds = 2",
    is_endless: true,
    build: |build| {
        let axes = *build.arguments().choice("corner").expect("it must be there");
        let graph = build.graph();
        let planes = [("x", DVec3::X), ("y", DVec3::Y), ("z", DVec3::Z)];
        let planes: Vec<Node> = planes
            .iter()
            .filter(|(name, _)| axes.contains(name))
            .map(|(_, axis)| graph.half_space(*axis, 0.0))
            .collect();
        let node =
            planes.into_iter().reduce(|corner, plane| graph.corner(corner, plane)).expect("there are two at least");
        Ok(graph.sloped(node, Slope::Exact { outside: true, inside: true }, None))
    },
    ..Spec::PLAIN
};
