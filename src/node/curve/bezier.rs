//! A tube along a Bézier curve.

use glam::DVec4;

use crate::node::curves::{bezier, tube, tube_points};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind};

/// A tube along a Bézier curve.
pub const NODE: Spec = Spec {
    key: Key::new("bezier", Kind::Rows(2, &[3, 4]), Required, "Tube along a Bézier curve of any degree, which begins at its first control point and ends at its last: `[x, y, z]`, or `[x, y, z, radius]` of each point.").unit("units"),
    parameters: &[
        Key::length("radius", Number(0.1), "The radius where a point has none of its own."),
    ],
    formula: "the greatest over the pieces of r − |p − q|, q the nearest of the piece and r the radius there",
    example: "bezier = [[-0.9, 0, -0.8, 0.25], [-0.9, 0, 1.6], [0.9, 0.8, -1.6], [0.9, 0, 0.8]]",
    build: |build| {
        let points = tube_points(build, "bezier")?;
        if points.len() > MOST {
            let problem = format!("`bezier` takes at most {MOST} control points");
            return Err(build.wrong("bezier", problem).help("`b_spline` takes any number, each of which moves only a part of the curve"));
        }
        let all: Vec<DVec4> = bezier(&points);
        Ok(tube(build.graph(), &all))
    },
    ..Spec::PLAIN
};

/// A curve of more is all but straight.
const MOST: usize = 32;
