//! OpenVDB's own morph of level sets, to compare with.

use std::sync::Arc;

use crate::morph::Union;
use crate::node::morph_mode::ModeSpec;

/// OpenVDB's morph.
pub const NODE: ModeSpec = ModeSpec {
    key: ModeSpec::named(
        "openvdb",
        "OpenVDB's own level-set morphing, to compare with: each frame made from the one before it, so one by itself takes \
         all before it; in even steps of as much time as the last place takes to come to rest. It flows only where the two \
         overlap, rounds edges, and its last frame is what it comes to, not the last object. Its objects stand still, and \
         it gives no `vel`.",
    ),
    parameters: &[],
    shared: &["over"],
    formula: "",
    source: "OpenVDB, tools/LevelSetMorph.h",
    example: "from = \"a\"\nto = \"b\"\nmode = \"openvdb\"",
    carries_apart: false,
    where_empty: None,
    by_level_sets: true,
    // Attributes go as ever, and what is in either object bounds the shape.
    build: |_| Ok(Arc::new(Union)),
};
