//! The wall around a shape's surface.

use crate::field::Interval;
use crate::node::spec::Spec;
use crate::text::key::Absent::Nothing;
use crate::text::key::{Key, Kind, Limit};

/// Only a wall stays.
pub const NODE: Spec = Spec {
    key: Key::new("shell", Kind::Number, Nothing, "Only a wall of this thickness stays, its middle on the surface.")
        .limit(Limit::Positive)
        .unit("units"),
    formula: "w/2 − |f|, f the signed distance",
    example: "box = 1\nshell = 0.1",
    measures: |_| true,
    build: |build| {
        let solid = build.inner()?;
        let (thickness, ever) = (build.number("shell")?, build.ever("shell")?);
        let (least, most) = (ever.lo / 2.0, ever.hi / 2.0);
        let outside = build.distance(solid, Interval::new(-most, -least), "shell")?;
        let inside = build.distance(solid, Interval::new(least, most), "shell")?;
        let wall = build.graph().wall(outside, inside, thickness);
        Ok(build.held(wall, solid, thickness / 2.0))
    },
    ..Spec::PLAIN
};
