//! A heart.

use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// A heart.
pub const NODE: Spec = Spec {
    key: Key::length(
        "heart",
        Required,
        "A heart around the origin, upright along z, front towards −y: its width along x.",
    ),
    formula: "z·∛(x² + 9/80·y²) − (x² + 9/4·y² + z² − 1), scaled: the cube roots of the well-known sextic",
    example: "heart = 2",
    build: |build| {
        let width = build.number("heart")?;
        Ok(build.graph().heart(width))
    },
    ..Spec::PLAIN
};
