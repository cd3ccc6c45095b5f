//! A difference whose surfaces are joined by steps.

use crate::node::blending::{BLEND_RADIUS, Joined, joined, stepped};
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A difference whose surfaces are joined by steps.
pub const NODE: Spec = Spec {
    key: Key::new(
        "stairs_difference",
        Kind::Shapes(2),
        Required,
        "The first without all others, with steps where their surfaces meet.",
    ),
    parameters: &[
        BLEND_RADIUS,
        Key::new("steps", Kind::Whole, Number(4.0), "How many edges go down across the corner.")
            .limit(Limit::Within(1.0, 64.0)),
    ],
    formula: "−(that of −a and b)",
    source: "Mercury, hg_sdf: fOpUnionStairs",
    example: "stairs_difference = [\"a\", \"b\"]",
    carries: Carries::First,
    measures: |_| true,
    build: |build| {
        let steps = build.arguments().whole("steps").map_or(1, |steps| *steps as u32);
        joined(build, "stairs_difference", Joined::Difference, |graph, a, b, radius| {
            stepped(graph, a, b, radius, steps)
        })
    },
    ..Spec::PLAIN
};
