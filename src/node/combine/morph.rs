//! A morph between two shapes, as a shape.

use crate::node::keys::COLOUR_SPACES;
use crate::node::morphed::CARRIES;
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::{Number, Required, Text, Words};
use crate::text::key::{Key, Kind, Limit};

/// A morph between two shapes, as a shape.
pub const NODE: Spec = Spec {
    key: Key::new(
        "morph",
        Kind::TwoShapes,
        Required,
        "Morph between two shapes, as a shape: what `[morph]` shows at one time, with its colours and attributes.",
    ),
    parameters: &[
        Key::new(
            "mix",
            Kind::Number,
            Number(0.5),
            "Position in the morph: 0 is the first shape, 1 the second. Equal steps change equal volumes.",
        )
        .limit(Limit::Within(0.0, 1.0)),
        Key::new(
            "bridge",
            Kind::Constant,
            Number(0.5),
            "How much separate shapes flow through one body: 0.05 is the shortest way.",
        )
        .limit(Limit::Within(0.05, 100.0)),
        Key::new(
            "carry",
            Kind::Choice(CARRIES),
            Words("`none` where the boxes of the two meet, else `centroid`"),
            "How both shapes travel from the first one's place to the second one's, as in `[morph]`.",
        ),
        Key::new("color_space", Kind::Choice(COLOUR_SPACES), Text("auto"), "How colours mix, as in `[morph]`.")
            .also(&["colour_space"]),
        Key::new(
            "alpha",
            Kind::Constant,
            Number(0.3),
            "STTI's α: 0.1 lets colours sweep over the shape, 3 changes them everywhere at once.",
        )
        .limit(Limit::NotNegative),
        Key::new(
            "beta",
            Kind::Constant,
            Number(0.5),
            "STTI's β: which shape's distance counts more for colours; 0.5 treats both alike.",
        )
        .limit(Limit::Within(0.0, 1.0)),
    ],
    formula: "f₁ ∨ f₂ + a₀·disp, a₀ from the volume",
    source: "STB and STTI, at one time",
    example: "morph = [\"a\", \"b\"]\nmix = 0.4",
    carries: Carries::Morph,
    build: |build| {
        let (morph, mix) = (build.morph()?, build.number("mix")?);
        let graph = build.graph();
        let node = graph.field(morph.profile(mix));
        // The box is that of the coarse grid: to within a cell.
        let aabb = morph.extent().grown(morph.plan().grid.edge());
        Ok(graph.bounded(node, if morph.is_of_plane() { aabb.without_z() } else { aabb }))
    },
    ..Spec::PLAIN
};
