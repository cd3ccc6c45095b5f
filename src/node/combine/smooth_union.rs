//! A union whose surfaces are smooth where they meet.

use crate::field::Kernel;
use crate::node::blending::{BLEND_RADIUS, Joined, joined};
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::{Required, Text};
use crate::text::key::{Key, Kind};

/// A union whose surfaces are smooth where they meet.
pub const NODE: Spec = Spec {
    key: Key::new(
        "smooth_union",
        Kind::Shapes(2),
        Required,
        "Their union, smooth where their surfaces meet. Of three and more the order counts, except with `kernel = \"exponential\"`.",
    ),
    parameters: &[
        BLEND_RADIUS,
        Key::new(
            "kernel",
            Kind::Choice(&["quadratic", "cubic", "circular", "exponential"]),
            Text("quadratic"),
            "What it is smooth by: polynomials of second and third degree, a piece of a circle, or exponentials, which are felt \
             everywhere.",
        ),
    ],
    formula: "max(a, b) + w·k(|a − b|/w)",
    source: "Quilez, Smooth minimum",
    example: "smooth_union = [\"a\", \"b\"]",
    carries: Carries::Blend,
    measures: |_| true,
    build: |build| {
        let kernel = match build.arguments().choice("kernel") {
            Some(&"cubic") => Kernel::Cubic,
            Some(&"circular") => Kernel::Circular,
            Some(&"exponential") => Kernel::Exponential,
            _ => Kernel::Quadratic,
        };
        joined(build, "smooth_union", Joined::Union, |graph, a, b, radius| graph.smooth_max(kernel, radius, a, b))
    },
    ..Spec::PLAIN
};
