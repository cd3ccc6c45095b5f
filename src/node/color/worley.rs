//! Cellular noise.

use crate::node::pattern::{COLOURS, EASE, NEAR, SEED, SPACE, colour, size, worley};
use crate::node::source::Source;

/// Cellular noise.
pub const NODE: Source<3> = Source {
    key: size("worley", "Distances to points scattered one a cell, 0 to 1: the size of the cells."),
    parameters: &[NEAR, SEED, COLOURS, SPACE, EASE],
    example: "{ worley = 0.4, colors = [\"#1d3557\", \"#f1faee\", \"#e63946\"] }",
    build: |source| colour(source, "worley", worley),
    ..Source::PLAIN
};
