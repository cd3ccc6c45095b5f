//! A difference whose surfaces are joined by a chamfer.

use crate::node::blending::{BLEND_RADIUS, Joined, chamfered, joined};
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// A difference whose surfaces are joined by a chamfer.
pub const NODE: Spec = Spec {
    key: Key::new(
        "chamfer_difference",
        Kind::Shapes(2),
        Required,
        "The first without all others, with a plane across the corner where their surfaces meet.",
    ),
    parameters: &[BLEND_RADIUS],
    formula: "min(a, −b, (a − b − r)/√2)",
    source: "Mercury, hg_sdf: fOpUnionChamfer",
    example: "chamfer_difference = [\"a\", \"b\"]",
    carries: Carries::First,
    measures: |_| true,
    build: |build| joined(build, "chamfer_difference", Joined::Difference, chamfered),
    ..Spec::PLAIN
};
