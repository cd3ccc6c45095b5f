//! The numbers of features, along the inside of the shape.

use crate::attribute::Straight;
use crate::attribute::conformal::Nearest;
use crate::node::conformal::{
    EASE, LATTICE, METHOD, OUTSIDE, SPEED, SPREAD, conformal, features, inside, speed_is_used,
};
use crate::node::painted::Paint;
use crate::node::source::Source;
use crate::text::key::Absent::{Required, Text};
use crate::text::key::{Key, Kind};

/// The numbers of features, along the inside of the shape.
pub const NODE: Source<1> = Source {
    key: Key::new(
        "conformal",
        Kind::Shapes(1),
        Required,
        "What the attribute of the same name is on each of these features, along the shape's inside, as colours have it; 0 \
         on those without it.",
    ),
    parameters: &[
        SPREAD,
        EASE,
        Key::new(
            "show",
            Kind::Choice(&["value", "cell"]),
            Text("value"),
            "The features' values, or which feature is nearest along the inside: 0 for the first.",
        ),
        LATTICE,
        METHOD,
        SPEED,
        OUTSIDE,
    ],
    formula: "Σ wₖaₖ / Σ wₖ, wₖ = Π max(dⱼ − dₖ + sₖⱼ, 0), sₖⱼ = spread · way between k and j (CONFORMAL, eq. 5, 9 to 11)",
    example: "{ conformal = [\"a\", \"b\"], show = \"cell\" }",
    is_conformal: true,
    check: speed_is_used,
    build: |source| {
        if source.arguments().choice("show") != Some(&"cell") {
            return conformal(source, |_, _| Straight);
        }
        let goals: Vec<_> = features(source)?.into_iter().map(Some).collect();
        let (body, features) = inside(source, &goals, "conformal")?;
        Ok(Paint::of(Nearest { body, features }))
    },
    ..Source::PLAIN
};
