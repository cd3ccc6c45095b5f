//! A shape whose outward edges are round.

use crate::field::Interval;
use crate::node::spec::Spec;
use crate::text::key::Absent::Nothing;
use crate::text::key::{Key, Kind, Limit};

/// Outward edges rounded.
pub const NODE: Spec = Spec {
    key: Key::new(
        "round",
        Kind::Number,
        Nothing,
        "Rounds outward edges and corners with this radius and keeps the size: all that a ball of this radius reaches from \
         within (opening). What is thinner than two radii vanishes.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    formula: "(f − r) + r, each by the signed distance",
    source: "Serra, Image Analysis and Mathematical Morphology, 1982: opening by a ball",
    example: "box = [1, 1.4, 0.8]\nround = 0.2",
    measures: |_| true,
    build: |build| {
        let solid = build.inner()?;
        let (radius, ever) = (build.number("round")?, build.ever("round")?);
        let inside = build.distance(solid, ever, "round")?;
        let less = build.graph().offset(inside, -radius);
        let less = build.held(less, solid, 0.0);
        let outside = build.distance(less, Interval::new(-ever.hi, -ever.lo), "round")?;
        let rounded = build.graph().offset(outside, radius);
        Ok(build.held(rounded, solid, 0.0))
    },
    ..Spec::PLAIN
};
