//! A union whose surfaces are joined by steps.

use crate::node::blending::{BLEND_RADIUS, Joined, joined, stepped};
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A union whose surfaces are joined by steps.
pub const NODE: Spec = Spec {
    key: Key::new("stairs_union", Kind::Shapes(2), Required, "Their union, with steps where their surfaces meet."),
    parameters: &[
        BLEND_RADIUS,
        Key::new("steps", Kind::Whole, Number(4.0), "How many edges go down across the corner.")
            .limit(Limit::Within(1.0, 64.0)),
    ],
    formula: "max(a, b, min(a + i·r/n, b + r − i·r/n) for 0 < i < n)",
    source: "Mercury, hg_sdf: fOpUnionStairs",
    example: "stairs_union = [\"a\", \"b\"]",
    carries: Carries::Blend,
    measures: |_| true,
    build: |build| {
        let steps = build.arguments().whole("steps").map_or(1, |steps| *steps as u32);
        joined(build, "stairs_union", Joined::Union, |graph, a, b, radius| stepped(graph, a, b, radius, steps))
    },
    ..Spec::PLAIN
};
