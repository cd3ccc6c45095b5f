//! A sum of octaves of noise.

use crate::field::Fold;
use crate::node::pattern::{COLOURS, EASE, OCTAVES, SEED, SPACE, colour, fractal, size};
use crate::node::source::Source;

/// A sum of octaves of noise.
pub const NODE: Source<3> = Source {
    key: size(
        "fbm",
        "Fractional Brownian motion, 0 to 1, a sum of octaves of Perlin noise: the size of the largest cells.",
    ),
    parameters: &[OCTAVES, SEED, COLOURS, SPACE, EASE],
    example: "{ fbm = 0.6, colors = [\"#1d3557\", \"#f1faee\", \"#e63946\"] }",
    build: |source| colour(source, "fbm", |arguments, graph, main| fractal(arguments, graph, main, Fold::Plain)),
    ..Source::PLAIN
};
