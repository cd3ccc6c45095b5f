//! A polyline of some width.

use glam::DVec3;

use crate::field::{Joined, Strut, Struts};
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind};

/// A polyline of some width.
pub const NODE: Spec = Spec {
    key: Key::new(
        "stroke",
        Kind::Rows(2, &[2, 3]),
        Required,
        "Lines between points, with round joints and ends: `[x, y]`, or `[x, y, width]` of each.",
    )
    .unit("units"),
    parameters: &[Key::length("width", Number(0.1), "The width where a point has none of its own.")],
    formula: "the greatest over the lines of w/2 − |p − q|, q the nearest of the line",
    example: "stroke = [[-0.8, -0.6], [-0.2, 0.6], [0.3, -0.3], [0.8, 0.5, 0.5]]\nwidth = 0.2",
    plane: Plane::Flat,
    build: |build| {
        let width = build.number("width")?;
        let rows = build.arguments().rows("stroke").expect("it must be there").all.clone();
        let mut points = Vec::with_capacity(rows.len());
        for row in rows {
            let width = row.get(2).copied().unwrap_or(width);
            if width <= 0.0 {
                return Err(build
                    .wrong("stroke", "a width must be greater than 0")
                    .help("the third number of a point is its width"));
            }
            points.push((DVec3::new(row[0], row[1], 0.0), width / 2.0));
        }
        let struts = points.array_windows().map(|&[(a, r), (b, s)]| Strut::new(a, b, [r, s])).collect();
        Ok(build.graph().field(Joined::shared(Struts::new(struts).flattened())))
    },
    ..Spec::PLAIN
};
