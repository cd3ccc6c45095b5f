//! An intersection whose surfaces are joined by columns.

use crate::node::blending::{BLEND_RADIUS, Joined, columned, joined};
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// An intersection whose surfaces are joined by columns.
pub const NODE: Spec = Spec {
    key: Key::new(
        "columns_intersection",
        Kind::Shapes(2),
        Required,
        "What lies in all of them, with columns side by side where their surfaces meet.",
    ),
    parameters: &[
        BLEND_RADIUS,
        Key::new("columns", Kind::Whole, Number(3.0), "How many.").limit(Limit::Within(1.0, 64.0)),
    ],
    formula: "−(that of −a and −b)",
    source: "Mercury, hg_sdf: fOpUnionColumns",
    example: "columns_intersection = [\"a\", \"b\"]\nblend_radius = 0.08",
    carries: Carries::Any,
    measures: |_| true,
    build: |build| {
        let columns = build.arguments().whole("columns").map_or(1, |columns| *columns as u32);
        joined(build, "columns_intersection", Joined::Intersection, |graph, a, b, radius| {
            columned(graph, a, b, radius, columns)
        })
    },
    ..Spec::PLAIN
};
