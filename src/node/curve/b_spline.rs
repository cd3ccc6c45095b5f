//! A tube along a B-spline.

use glam::DVec4;

use crate::node::curves::{b_spline, tube, tube_points};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Required, Text};
use crate::text::key::{Key, Kind};

/// A tube along a B-spline.
pub const NODE: Spec = Spec {
    key: Key::new("b_spline", Kind::Rows(4, &[3, 4]), Required, "Tube along a uniform cubic B-spline, which its control points draw towards themselves: `[x, y, z]`, or `[x, y, z, radius]` of each point.").unit("units"),
    parameters: &[
        Key::length("radius", Number(0.1), "The radius where a point has none of its own."),
        Key::new("ends", Kind::Choice(&["open", "closed"]), Text("open"), "`closed` joins the end to the beginning."),
    ],
    formula: "the greatest over the pieces of r − |p − q|, q the nearest of the piece and r the radius there",
    example: "b_spline = [[-0.9, 0, -0.8, 0.25], [-0.9, 0, 0.8], [0, 0.9, 0.8], [0.4, 0.4, -0.8], [0.9, -0.6, 0.4]]",
    build: |build| {
        let points = tube_points(build, "b_spline")?;
        let closed = build.arguments().choice("ends") == Some(&"closed");
        let all: Vec<DVec4> = b_spline(&points, closed);
        Ok(tube(build.graph(), &all))
    },
    ..Spec::PLAIN
};
