//! A shape filled with a structure.

use crate::field::Interval;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Nothing, Number};
use crate::text::key::{Key, Kind, Limit};

/// A shape filled with a structure.
pub const NODE: Spec = Spec {
    key: Key::new(
        "fill",
        Kind::Shape,
        Nothing,
        "What its inside is made of: another shape, such as `gyroid`, `foam` or `pores`, where that stands in this one's own \
         space.",
    ),
    parameters: &[Key::new(
        "skin",
        Kind::Number,
        Number(0.0),
        "How thick the whole material below the surface is; 0 is none: the structure is open.",
    )
    .limit(Limit::NotNegative)
    .unit("units")],
    formula: "min(f, max(g, s − f)), f the signed distance, g the structure",
    source: "HFRep, figure 14",
    example: "sphere = 1\nfill = { gyroid = 0.6, thickness = 0.12 }",
    measures: |_| true,
    build: |build| {
        let solid = build.inner()?;
        let structure = *build.arguments().shape("fill").expect("it must be there");
        let structure = build.shape(structure)?;
        let (skin, ever) = (build.number("skin")?, build.ever("skin")?);
        let inside = if ever.hi > 0.0 {
            let distance = build.distance(solid, Interval::new(0.0, ever.hi), "skin")?;
            let graph = build.graph();
            let wall = graph.linear(distance, -1.0, skin);
            graph.max(structure, wall)
        } else {
            structure
        };
        let filled = build.graph().min(solid, inside);
        Ok(build.held(filled, solid, 0.0))
    },
    ..Spec::PLAIN
};
