//! A union whose surfaces are joined by a chamfer.

use crate::node::blending::{BLEND_RADIUS, Joined, chamfered, joined};
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// A union whose surfaces are joined by a chamfer.
pub const NODE: Spec = Spec {
    key: Key::new(
        "chamfer_union",
        Kind::Shapes(2),
        Required,
        "Their union, with a plane across the corner where their surfaces meet.",
    ),
    parameters: &[BLEND_RADIUS],
    formula: "max(a, b, (a + b + r)/√2)",
    source: "Mercury, hg_sdf: fOpUnionChamfer",
    example: "chamfer_union = [\"a\", \"b\"]",
    carries: Carries::Blend,
    measures: |_| true,
    build: |build| joined(build, "chamfer_union", Joined::Union, chamfered),
    ..Spec::PLAIN
};
