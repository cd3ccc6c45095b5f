//! An intersection whose surfaces are joined by a chamfer.

use crate::node::blending::{BLEND_RADIUS, Joined, chamfered, joined};
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// An intersection whose surfaces are joined by a chamfer.
pub const NODE: Spec = Spec {
    key: Key::new(
        "chamfer_intersection",
        Kind::Shapes(2),
        Required,
        "What lies in all of them, with a plane across the corner where their surfaces meet.",
    ),
    parameters: &[BLEND_RADIUS],
    formula: "min(a, b, (a + b − r)/√2)",
    source: "Mercury, hg_sdf: fOpUnionChamfer",
    example: "chamfer_intersection = [\"a\", \"b\"]\nblend_radius = 0.08",
    carries: Carries::Any,
    measures: |_| true,
    build: |build| joined(build, "chamfer_intersection", Joined::Intersection, chamfered),
    ..Spec::PLAIN
};
