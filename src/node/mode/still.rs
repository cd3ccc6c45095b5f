//! A shape that stays while its attributes go over.

use std::sync::Arc;

use crate::morph::Still;
use crate::node::morph_mode::ModeSpec;

/// The first object all along.
pub const NODE: ModeSpec = ModeSpec {
    key: ModeSpec::named(
        "still",
        "The shape stays the first one; colours and attributes alone go over, first where the last one is near. With `octopus` they creep on.",
    ),
    parameters: &[],
    shared: &[],
    formula: "f₁",
    source: "STTI, section 6.3",
    example: "from = \"a\"\nto = \"b\"\nmode = \"still\"",
    carries_apart: false,
    where_empty: None,
    by_level_sets: false,
    build: |_| Ok(Arc::new(Still)),
};
