//! Cellular noise.

use crate::node::pattern::{BETWEEN, NEAR, SEED, number, size, worley};
use crate::node::source::Source;

/// Cellular noise.
pub const NODE: Source<1> = Source {
    key: size("worley", "Distances to points scattered one a cell, 0 to 1: the size of the cells."),
    parameters: &[NEAR, SEED, BETWEEN],
    example: "{ worley = 0.4 }",
    build: |source| number(source, "worley", worley),
    ..Source::PLAIN
};
