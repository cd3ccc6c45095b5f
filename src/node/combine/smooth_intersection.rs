//! An intersection whose surfaces are smooth where they meet.

use crate::node::blending::{BLEND_RADIUS, Joined, KERNEL, joined, kernel};
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// An intersection whose surfaces are smooth where they meet.
pub const NODE: Spec = Spec {
    key: Key::new(
        "smooth_intersection",
        Kind::Shapes(2),
        Required,
        "What lies in all of them, smooth where their surfaces meet. Of three and more the order counts, except with `kernel = \"exponential\"`.",
    ),
    parameters: &[BLEND_RADIUS, KERNEL],
    formula: "min(a, b) − w·k(|a − b|/w)",
    source: "Quilez, Smooth minimum",
    example: "smooth_intersection = [\"a\", \"b\"]\nblend_radius = 0.08",
    carries: Carries::Any,
    measures: |_| true,
    build: |build| {
        let kernel = kernel(build);
        joined(build, "smooth_intersection", Joined::Intersection, |graph, a, b, radius| {
            graph.smooth_max(kernel, radius, a, b)
        })
    },
    ..Spec::PLAIN
};
