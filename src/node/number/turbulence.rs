//! Noise with valleys.

use crate::field::Fold;
use crate::node::pattern::{BETWEEN, OCTAVES, SEED, fractal, number, size};
use crate::node::source::Source;

/// Noise with valleys.
pub const NODE: Source<1> = Source {
    key: size("turbulence", "A sum of octaves of noise folded to valleys, 0 to 1: the size of the largest cells."),
    parameters: &[OCTAVES, SEED, BETWEEN],
    example: "{ turbulence = 0.6 }",
    build: |source| {
        number(source, "turbulence", |arguments, graph, main| fractal(arguments, graph, main, Fold::Turbulence))
    },
    ..Source::PLAIN
};
