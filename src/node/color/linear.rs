//! Scene-linear numbers.

use crate::attribute::Components;
use crate::node::direct::of_components;
use crate::node::source::Source;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// Scene-linear numbers.
pub const NODE: Source<3> = Source {
    key: Key::new(
        "linear",
        Kind::Components(Components::Linear),
        Required,
        "Scene-linear red, green, blue, each 0 or greater. Formulas are held to that.",
    ),
    example: "{ linear = [\"0.5 + x\", 0.2, 1.5] }",
    build: |source| of_components(source, "linear", Components::Linear),
    ..Source::PLAIN
};
