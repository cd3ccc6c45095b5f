//! A shape whose inward edges are round.

use crate::field::Interval;
use crate::node::spec::Spec;
use crate::text::key::Absent::Nothing;
use crate::text::key::{Key, Kind, Limit};

/// Inward edges rounded.
pub const NODE: Spec = Spec {
    key: Key::new(
        "fillet",
        Kind::Number,
        Nothing,
        "Rounds inward edges with this radius and keeps the size: all that a ball of this radius cannot reach from without \
         (closing). Gaps narrower than two radii are filled.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    formula: "(f + r) − r, each by the signed distance",
    source: "Serra, Image Analysis and Mathematical Morphology, 1982: closing by a ball",
    example: "union = [\"a\", \"b\"]\nfillet = 0.15",
    measures: |_| true,
    build: |build| {
        let solid = build.inner()?;
        let (radius, ever) = (build.number("fillet")?, build.ever("fillet")?);
        let outside = build.distance(solid, Interval::new(-ever.hi, -ever.lo), "fillet")?;
        let more = build.graph().offset(outside, radius);
        let more = build.held(more, solid, radius);
        let inside = build.distance(more, ever, "fillet")?;
        let filled = build.graph().offset(inside, -radius);
        Ok(build.held(filled, solid, radius))
    },
    ..Spec::PLAIN
};
