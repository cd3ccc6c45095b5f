//! Hue, saturation and value.

use crate::attribute::Components;
use crate::node::direct::of_components;
use crate::node::source::Source;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// Hue, saturation and value.
pub const NODE: Source<3> = Source {
    key: Key::new(
        "hsv",
        Kind::Components(Components::Hsv),
        Required,
        "Hue in degrees, saturation and value from 0 to 1, of the sRGB-encoded colour. Formulas are held to that.",
    ),
    example: "{ hsv = [\"360*x\", 0.8, 1] }",
    build: |source| of_components(source, "hsv", Components::Hsv),
    ..Source::PLAIN
};
