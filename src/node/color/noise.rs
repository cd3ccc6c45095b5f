//! Value noise.

use crate::field::ValueNoise;
use crate::node::pattern::{COLOURS, EASE, SEED, SPACE, colour, noise, size};
use crate::node::source::Source;

/// Value noise.
pub const NODE: Source<3> = Source {
    key: size("noise", "Value noise, 0 to 1: the size of its cells."),
    parameters: &[SEED, COLOURS, SPACE, EASE],
    example: "{ noise = 0.4, colors = [\"#1d3557\", \"#f1faee\", \"#e63946\"] }",
    build: |source| {
        colour(source, "noise", |arguments, graph, main| noise(arguments, graph, main, |seed| ValueNoise { seed }))
    },
    ..Source::PLAIN
};
