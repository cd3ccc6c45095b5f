//! A difference whose surfaces are joined by a fillet.

use crate::node::blending::{BLEND_RADIUS, Joined, joined, rounded};
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// A difference whose surfaces are joined by a fillet.
pub const NODE: Spec = Spec {
    key: Key::new(
        "round_difference",
        Kind::Shapes(2),
        Required,
        "The first without all others, with a fillet where their surfaces meet: a quarter of a circle of this radius at a right angle.",
    ),
    parameters: &[BLEND_RADIUS],
    formula: "−(that of −a and b)",
    source: "Mercury, hg_sdf: fOpUnionRound",
    example: "round_difference = [\"a\", \"b\"]",
    carries: Carries::First,
    measures: |_| true,
    build: |build| joined(build, "round_difference", Joined::Difference, rounded),
    ..Spec::PLAIN
};
