//! Noise with crests.

use crate::field::Fold;
use crate::node::pattern::{BETWEEN, OCTAVES, SEED, fractal, number, size};
use crate::node::source::Source;

/// Noise with crests.
pub const NODE: Source<1> = Source {
    key: size("ridged", "A sum of octaves of noise folded to crests, 0 to 1: the size of the largest cells."),
    parameters: &[OCTAVES, SEED, BETWEEN],
    example: "{ ridged = 0.6 }",
    build: |source| number(source, "ridged", |arguments, graph, main| fractal(arguments, graph, main, Fold::Ridged)),
    ..Source::PLAIN
};
