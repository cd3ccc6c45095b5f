//! A union whose surfaces are joined by a fillet.

use crate::node::blending::{BLEND_RADIUS, Joined, joined, rounded};
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// A union whose surfaces are joined by a fillet.
pub const NODE: Spec = Spec {
    key: Key::new(
        "round_union",
        Kind::Shapes(2),
        Required,
        "Their union, with a fillet where their surfaces meet: a quarter of a circle of this radius at a right angle.",
    ),
    parameters: &[BLEND_RADIUS],
    formula: "min(max(a, b), −r) + |(max(a + r, 0), max(b + r, 0))|",
    source: "Mercury, hg_sdf: fOpUnionRound",
    example: "round_union = [\"a\", \"b\"]",
    carries: Carries::Blend,
    measures: |_| true,
    build: |build| joined(build, "round_union", Joined::Union, rounded),
    ..Spec::PLAIN
};
