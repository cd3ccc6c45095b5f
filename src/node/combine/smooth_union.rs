//! A union whose surfaces are smooth where they meet.

use crate::node::blending::{BLEND_RADIUS, Joined, KERNEL, joined, kernel};
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// A union whose surfaces are smooth where they meet.
pub const NODE: Spec = Spec {
    key: Key::new(
        "smooth_union",
        Kind::Shapes(2),
        Required,
        "Their union, smooth where their surfaces meet. Of three and more the order counts, except with `kernel = \"exponential\"`.",
    ),
    parameters: &[BLEND_RADIUS, KERNEL],
    formula: "max(a, b) + w·k(|a − b|/w)",
    source: "Quilez, Smooth minimum",
    example: "smooth_union = [\"a\", \"b\"]",
    carries: Carries::Blend,
    measures: |_| true,
    build: |build| {
        let kernel = kernel(build);
        joined(build, "smooth_union", Joined::Union, |graph, a, b, radius| graph.smooth_max(kernel, radius, a, b))
    },
    ..Spec::PLAIN
};
