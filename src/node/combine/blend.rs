//! Shapes that flow together.

use crate::field::{Blend, BlendBounds, Interval};
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::{Nothing, Number, Required};
use crate::text::key::{Key, Kind};

/// Shapes that flow together.
pub const NODE: Spec = Spec {
    key: Key::new("blend", Kind::Shapes(2), Required, "Two shapes that flow into one another."),
    parameters: &[
        Key::length("blend_radius", Number(0.25), "How near they must be to one another to flow together."),
        Key::new("within", Kind::Shape, Nothing, "The blend stays within this shape (bounded blending)."),
    ],
    formula: "a + b + √(a² + b²) + a₀·disp",
    source: "Pasko and others, bounded blending",
    example: "blend = [\"a\", \"b\"]",
    carries: Carries::Blend,
    measures: |_| true,
    build: |build| {
        let (amount, most) = (build.number("blend_radius")?, build.ever("blend_radius")?.hi);
        let shapes = build.arguments().shapes("blend").cloned().unwrap_or_default();
        // The blend lies outside of all, and within its bounds.
        let mut nodes = Vec::with_capacity(shapes.len());
        for id in shapes {
            nodes.push(build.shape_distance(id, Interval::new(-most, 0.0), "blend_radius")?);
        }
        let bounds = match build.arguments().shape("within").copied() {
            Some(id) => {
                let solid = build.shape_distance(id, Interval::new(0.0, most), "blend_radius")?;
                Some(BlendBounds { solid, weight: amount })
            }
            None => None,
        };
        let blend = Blend { amount, reach: [amount; 2], bounds };
        // One after another: the first with the second, that with the third.
        let joined = nodes.into_iter().reduce(|joined, next| build.graph().blend_union(joined, next, &blend));
        Ok(joined.unwrap_or_else(|| unreachable!("a blend has two operands")))
    },
    ..Spec::PLAIN
};
