//! A sum of octaves of noise.

use crate::field::Fold;
use crate::node::pattern::{BETWEEN, OCTAVES, SEED, fractal, number, size};
use crate::node::source::Source;

/// A sum of octaves of noise.
pub const NODE: Source<1> = Source {
    key: size(
        "fbm",
        "Fractional Brownian motion, 0 to 1, a sum of octaves of Perlin noise: the size of the largest cells.",
    ),
    parameters: &[OCTAVES, SEED, BETWEEN],
    example: "{ fbm = 0.6 }",
    build: |source| number(source, "fbm", |arguments, graph, main| fractal(arguments, graph, main, Fold::Plain)),
    ..Source::PLAIN
};
