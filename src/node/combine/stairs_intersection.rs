//! An intersection whose surfaces are joined by steps.

use crate::node::blending::{BLEND_RADIUS, Joined, joined, stepped};
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// An intersection whose surfaces are joined by steps.
pub const NODE: Spec = Spec {
    key: Key::new(
        "stairs_intersection",
        Kind::Shapes(2),
        Required,
        "What lies in all of them, with steps where their surfaces meet.",
    ),
    parameters: &[
        BLEND_RADIUS,
        Key::new("steps", Kind::Whole, Number(4.0), "How many edges go down across the corner.")
            .limit(Limit::Within(1.0, 64.0)),
    ],
    formula: "−(that of −a and −b)",
    source: "Mercury, hg_sdf: fOpUnionStairs",
    example: "stairs_intersection = [\"a\", \"b\"]\nblend_radius = 0.08",
    carries: Carries::Any,
    measures: |_| true,
    build: |build| {
        let steps = build.arguments().whole("steps").map_or(1, |steps| *steps as u32);
        joined(build, "stairs_intersection", Joined::Intersection, |graph, a, b, radius| {
            stepped(graph, a, b, radius, steps)
        })
    },
    ..Spec::PLAIN
};
