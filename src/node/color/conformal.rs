//! The colours of features, along the inside of the shape.

use crate::attribute::{ColourSpace, Mixer};
use crate::node::conformal::{EASE, LATTICE, METHOD, OUTSIDE, SPEED, SPREAD, conformal, speed_is_used};
use crate::node::pattern::SPACE;
use crate::node::source::Source;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// The colours of features, along the inside of the shape.
pub const NODE: Source<3> = Source {
    key: Key::new(
        "conformal",
        Kind::Shapes(1),
        Required,
        "Features, whose colours go over into one another along the shape's inside, not through the air: each by the \
         length of the shortest way inside to it. In a feature its own colour, the later one's where features overlap. \
         Features stand in the shape's own space, as it is before what bends that, and do not change its form; a ball \
         stands for a point.",
    ),
    parameters: &[SPREAD, EASE, SPACE, LATTICE, METHOD, SPEED, OUTSIDE],
    formula: "Σ wₖcₖ / Σ wₖ, wₖ = Π max(dⱼ − dₖ + sₖⱼ, 0), sₖⱼ = spread · way between k and j (CONFORMAL, eq. 5, 9 to 11)",
    example: "{ conformal = [\"a\", \"b\"] }",
    is_conformal: true,
    check: speed_is_used,
    build: |source| {
        let name = source.arguments().choice("color_space").copied();
        let space = name.and_then(ColourSpace::named).unwrap_or(ColourSpace::Oklab);
        conformal(source, |from, to| Mixer::between(space, from, to))
    },
    ..Source::PLAIN
};
