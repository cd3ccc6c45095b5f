//! A screw thread.

use glam::DVec3;

use crate::field::Aabb;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required, Text};
use crate::text::key::{Key, Kind};

/// A screw thread.
pub const NODE: Spec = Spec {
    key: Key::length(
        "thread",
        Required,
        "Rod with a screw thread along z around the origin: the radius of its crests.",
    )
    .also(&["screw"]),
    parameters: &[
        Key::length("pitch", Of("thread", 0.4), "How far one turn rises."),
        Key::length("depth", Of("pitch", 0.6), "From its crests to the bottom of its grooves."),
        Key::length("height", Of("thread", 3.0), "From its bottom to its top."),
        Key::new("hand", Kind::Choice(&["right", "left"]), Text("right"), "Which way it winds."),
    ],
    formula: "R − d·w − |(x, y)|, w the share of the way from a crest to the groove, within two planes",
    example: "thread = 0.6",
    build: |build| {
        let (radius, pitch) = (build.number("thread")?, build.number("pitch")?);
        let (depth, height) = (build.number("depth")?, build.number("height")?);
        let hand = if build.arguments().choice("hand") == Some(&"left") { -1.0 } else { 1.0 };
        if depth >= radius {
            let problem = format!("`depth` must be less than the radius, {radius}");
            return Err(build.wrong("depth", problem).help("a finer `pitch`, or a smaller `depth`"));
        }
        let graph = build.graph();
        let (x, y) = (graph.x(), graph.affine(DVec3::Y * hand, 0.0));
        // The angle from the crest at this height, from (x, y) turned back by the turn there: no seam.
        let turn = graph.affine(DVec3::Z * (std::f64::consts::TAU / pitch), 0.0);
        let (sin, cos) = (graph.sin(turn), graph.cos(turn));
        let [xc, ys, yc, xs] = [(x, cos), (y, sin), (y, cos), (x, sin)].map(|(a, b)| graph.mul(a, b));
        let (along, aside) = (graph.add(xc, ys), graph.sub(yc, xs));
        let angle = graph.atan2(aside, along);
        let share = graph.abs(angle);
        let groove = graph.linear(share, -depth / std::f64::consts::PI, radius);
        let across = graph.radius_about_z();
        let side = graph.sub(groove, across);
        let caps = graph.slab(DVec3::Z, height);
        let node = graph.min(side, caps);
        let half = DVec3::new(radius, radius, height / 2.0);
        Ok(graph.bounded(node, Aabb::new(-half, half)))
    },
    ..Spec::PLAIN
};
