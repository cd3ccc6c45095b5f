//! The twelve edges of a box as bars.

use glam::DVec3;

use crate::field::{Aabb, Slope};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// The twelve edges of a box as bars.
pub const NODE: Spec = Spec {
    key: Key::new(
        "box_frame",
        Kind::Lengths,
        Required,
        "The twelve edges of a box around the origin as square bars: the box's edge lengths; one number is a cube.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    parameters: &[Key::length("bar", Number(0.1), "The thickness of its bars.")],
    formula: "the greatest of three families of four bars, each the signed distance",
    example: "box_frame = [1.6, 1.2, 0.8]\nbar = 0.15",
    build: |build| {
        let (edges, bar) = (build.vector("box_frame")?, build.number("bar")?);
        if 2.0 * bar > edges.min_element() {
            let most = edges.min_element() / 2.0;
            let problem =
                format!("`bar` is more than half of the shortest edge, {most}: nothing is left between the bars");
            return Err(build.wrong("bar", problem).help("a thinner bar, or `box`"));
        }
        let graph = build.graph();
        let axes = [(DVec3::X, edges.x), (DVec3::Y, edges.y), (DVec3::Z, edges.z)];
        let within = axes.map(|(axis, edge)| graph.slab(axis, edge));
        // Between an outer face and the bar's inner one, on both sides at once.
        let beside = within.map(|slab| {
            let from_middle = graph.linear(slab, 1.0, -bar / 2.0);
            let from_middle = graph.abs(from_middle);
            graph.linear(from_middle, -1.0, bar / 2.0)
        });
        let bars = [0, 1, 2].map(|axis| {
            let (second, third) = (beside[(axis + 1) % 3], beside[(axis + 2) % 3]);
            let section = graph.corner(second, third);
            graph.corner(section, within[axis])
        });
        let frame = bars.into_iter().reduce(|frame, bars| graph.max(frame, bars)).expect("there are three");
        // Inside where bars meet the nearest face may belong to another bar.
        let slope = Slope::Exact { outside: true, inside: false };
        Ok(graph.sloped(frame, slope, Some(Aabb::new(-edges / 2.0, edges / 2.0))))
    },
    ..Spec::PLAIN
};
