//! The plain union on the way.

use std::sync::Arc;

use crate::morph::Union;
use crate::node::morph_mode::ModeSpec;

/// Both objects at once.
pub const NODE: ModeSpec = ModeSpec {
    key: ModeSpec::named(
        "union",
        "Both objects at once on the way, so it jumps at both ends: what space-time blending smooths out.",
    ),
    parameters: &[],
    shared: &["over", "through", "at"],
    formula: "max(f₁, f₂)",
    source: "",
    example: "from = \"a\"\nto = \"b\"\nmode = \"union\"",
    carries_apart: false,
    where_empty: None,
    by_level_sets: false,
    build: |_| Ok(Arc::new(Union)),
};
