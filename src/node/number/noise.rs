//! Value noise.

use crate::field::ValueNoise;
use crate::node::pattern::{BETWEEN, SEED, noise, number, size};
use crate::node::source::Source;

/// Value noise.
pub const NODE: Source<1> = Source {
    key: size("noise", "Value noise, 0 to 1: the size of its cells."),
    parameters: &[SEED, BETWEEN],
    example: "{ noise = 0.4 }",
    build: |source| {
        number(source, "noise", |arguments, graph, main| noise(arguments, graph, main, |seed| ValueNoise { seed }))
    },
    ..Source::PLAIN
};
