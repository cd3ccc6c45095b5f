//! Shapes that flow together.

use crate::field::{Blend, BlendBounds, Interval};
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::{Nothing, Number, Required, Words};
use crate::text::key::{Key, Kind, Limit};

/// Shapes that flow together.
pub const NODE: Spec = Spec {
    key: Key::new("blend", Kind::Shapes(2), Required, "Two shapes that flow into one another."),
    parameters: &[
        Key::length("blend_radius", Number(0.25), "How near they must be to one another to flow together."),
        Key::new(
            "mix",
            Kind::Number,
            Nothing,
            "For two shapes: mixes their colours and attributes as a morph does at this time (0 is the first shape, 1 the \
             second), instead of by their distances alone (STTI, figure 13).",
        )
        .limit(Limit::Within(0.0, 1.0)),
        Key::new(
            "alpha",
            Kind::Number,
            Words("`0.3`"),
            "With `mix`: STTI's α; 0.1 lets colours sweep over the shape, 3 mixes them everywhere alike.",
        )
        .limit(Limit::NotNegative),
        Key::new("within", Kind::Shape, Nothing, "The blend stays within this shape (bounded blending)."),
    ],
    formula: "a + b + √(a² + b²) + a₀·disp",
    source: "Pasko and others, bounded blending",
    example: "blend = [\"a\", \"b\"]",
    carries: Carries::Blend,
    measures: |_| true,
    build: |build| {
        if build.arguments().number("alpha").is_some() && build.arguments().number("mix").is_none() {
            return Err(build.wrong("alpha", "`alpha` counts beside `mix`, which is not there").help("mix = 0.5"));
        }
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
