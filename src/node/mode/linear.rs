//! Linear blending of two distances.

use std::sync::Arc;

use crate::morph::Linear;
use crate::node::morph_mode::{ModeSpec, SHARED};

/// The mean of the two distances.
pub const NODE: ModeSpec = ModeSpec {
    key: ModeSpec::named("linear", "The mean of the two distances; objects that lie apart vanish on the way."),
    parameters: &[],
    shared: &SHARED,
    formula: "(1 − t)·f₁ + t·f₂",
    source: "",
    example: "from = \"a\"\nto = \"b\"\nmode = \"linear\"",
    carries_apart: false,
    where_empty: Some(
        "linear blending needs objects that overlap: `carry = \"centroid\"` brings them together, or use \
         `mode = \"volume\"`",
    ),
    by_level_sets: false,
    build: |setting| Ok(Arc::new(Linear { pace: setting.pace() })),
};
