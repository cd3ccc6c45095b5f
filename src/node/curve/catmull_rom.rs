//! A tube along a curve through points.

use glam::DVec4;

use crate::node::curves::{catmull_rom, tube, tube_points};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Required, Text};
use crate::text::key::{Key, Kind};

/// A tube along a curve through points.
pub const NODE: Spec = Spec {
    key: Key::new("catmull_rom", Kind::Rows(2, &[3, 4]), Required, "Tube along a smooth curve through points, Catmull and Rom's: `[x, y, z]`, or `[x, y, z, radius]` of each point. A `cylinder` with `bend_along` has colours that go along it.").unit("units"),
    parameters: &[
        Key::length("radius", Number(0.1), "The radius where a point has none of its own."),
        Key::new("ends", Kind::Choice(&["open", "closed"]), Text("open"), "`closed` joins the end to the beginning."),
    ],
    formula: "the greatest over the pieces of r − |p − q|, q the nearest of the piece and r the radius there",
    example: "catmull_rom = [[-0.8, 0, -0.8], [-0.6, 0, 0.6, 0.2], [0.4, 0.6, 0.6], [0.8, -0.5, -0.2]]\nends = \"closed\"",
    build: |build| {
        let points = tube_points(build, "catmull_rom")?;
        let closed = build.arguments().choice("ends") == Some(&"closed");
        let all: Vec<DVec4> = catmull_rom(&points, closed);
        Ok(tube(build.graph(), &all))
    },
    ..Spec::PLAIN
};
