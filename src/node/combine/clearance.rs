//! A shape with room for another.

use crate::field::{Interval, SetSystem};
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind};

/// A shape with room for another.
pub const NODE: Spec = Spec {
    key: Key::new(
        "clearance",
        Kind::Shapes(2),
        Required,
        "The first with room for all others: without all that is near them.",
    ),
    parameters: &[Key::length("gap", Number(0.05), "How near.")],
    formula: "min(a, −(b + g))",
    source: "libfive: clearance",
    example: "clearance = [\"a\", \"b\"]\ngap = 0.1",
    carries: Carries::First,
    measures: |_| true,
    build: |build| {
        let (gap, ever) = (build.number("gap")?, build.ever("gap")?);
        let shapes = build.arguments().shapes("clearance").cloned().unwrap_or_default();
        let mut room = Vec::with_capacity(shapes.len() - 1);
        for id in &shapes[1..] {
            let distance = build.shape_distance(*id, Interval::new(-ever.hi, -ever.lo), "gap")?;
            room.push(build.graph().offset(distance, gap));
        }
        let first = build.shape(shapes[0])?;
        Ok(build.graph().difference(SetSystem::MinMax, first, &room))
    },
    ..Spec::PLAIN
};
