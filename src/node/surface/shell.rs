//! The wall around a shape's surface.

use crate::field::Interval;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Nothing, Text};
use crate::text::key::{Key, Kind, Limit};

/// Only a wall stays.
pub const NODE: Spec = Spec {
    key: Key::new("shell", Kind::Number, Nothing, "Only a wall of this thickness stays, its middle on the surface.")
        .limit(Limit::Positive)
        .unit("units"),
    parameters: &[Key::new(
        "wall",
        Kind::Choice(&["centred", "inner", "outer"]),
        Text("centred"),
        "Where the wall is: its middle on the surface, all of it inside, or all outside.",
    )],
    formula: "w/2 − |f|, f the signed distance; min(f, w − f) inner; min(−f, w + f) outer",
    example: "box = 1\nshell = 0.1",
    measures: |_| true,
    build: |build| {
        let solid = build.inner()?;
        let (thickness, ever) = (build.number("shell")?, build.ever("shell")?);
        match build.arguments().choice("wall") {
            Some(&"inner") => {
                let distance = build.distance(solid, Interval::new(0.0, ever.hi), "shell")?;
                let graph = build.graph();
                let core = graph.linear(distance, -1.0, thickness);
                let wall = graph.min(distance, core);
                Ok(build.held(wall, solid, 0.0))
            }
            Some(&"outer") => {
                let distance = build.distance(solid, Interval::new(-ever.hi, 0.0), "shell")?;
                let graph = build.graph();
                let (whole, without) = (graph.offset(distance, thickness), graph.neg(distance));
                let wall = graph.min(whole, without);
                Ok(build.held(wall, solid, thickness))
            }
            _ => {
                let (least, most) = (ever.lo / 2.0, ever.hi / 2.0);
                let outside = build.distance(solid, Interval::new(-most, -least), "shell")?;
                let inside = build.distance(solid, Interval::new(least, most), "shell")?;
                let wall = build.graph().wall(outside, inside, thickness);
                Ok(build.held(wall, solid, thickness / 2.0))
            }
        }
    },
    ..Spec::PLAIN
};
