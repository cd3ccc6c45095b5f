//! An intersection whose surfaces are joined by a fillet.

use crate::node::blending::{BLEND_RADIUS, Joined, joined, rounded};
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// An intersection whose surfaces are joined by a fillet.
pub const NODE: Spec = Spec {
    key: Key::new(
        "round_intersection",
        Kind::Shapes(2),
        Required,
        "What lies in all of them, with a fillet where their surfaces meet: a quarter of a circle of this radius at a right angle.",
    ),
    parameters: &[BLEND_RADIUS],
    formula: "−(that of −a and −b)",
    source: "Mercury, hg_sdf: fOpUnionRound",
    example: "round_intersection = [\"a\", \"b\"]\nblend_radius = 0.08",
    carries: Carries::Any,
    measures: |_| true,
    build: |build| joined(build, "round_intersection", Joined::Intersection, rounded),
    ..Spec::PLAIN
};
