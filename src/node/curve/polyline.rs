//! A tube along straight lines.

use glam::DVec4;

use crate::node::curves::{tube, tube_points};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Required, Text};
use crate::text::key::{Key, Kind};

/// A tube along straight lines.
pub const NODE: Spec = Spec {
    key: Key::new("polyline", Kind::Rows(2, &[3, 4]), Required, "Tube along straight lines between points, with round joints and ends: `[x, y, z]`, or `[x, y, z, radius]` of each point.").unit("units"),
    parameters: &[
        Key::length("radius", Number(0.1), "The radius where a point has none of its own."),
        Key::new("ends", Kind::Choice(&["open", "closed"]), Text("open"), "`closed` joins the end to the beginning."),
    ],
    formula: "the greatest over the pieces of r − |p − q|, q the nearest of the piece and r the radius there",
    example: "polyline = [[-0.8, 0, -0.8], [-0.8, 0, 0.6, 0.2], [0.4, 0.6, 0.6], [0.8, -0.5, 0]]",
    build: |build| {
        let points = tube_points(build, "polyline")?;
        let closed = build.arguments().choice("ends") == Some(&"closed");
        let loops = closed.then(|| points[0]);
        let all: Vec<DVec4> = points.into_iter().chain(loops).collect();
        Ok(tube(build.graph(), &all))
    },
    ..Spec::PLAIN
};
