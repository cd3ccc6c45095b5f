//! Noise with valleys.

use crate::field::Fold;
use crate::node::pattern::{COLOURS, EASE, OCTAVES, SEED, SPACE, colour, fractal, size};
use crate::node::source::Source;

/// Noise with valleys.
pub const NODE: Source<3> = Source {
    key: size("turbulence", "A sum of octaves of noise folded to valleys, 0 to 1: the size of the largest cells."),
    parameters: &[OCTAVES, SEED, COLOURS, SPACE, EASE],
    example: "{ turbulence = 0.6, colors = [\"#1d3557\", \"#f1faee\", \"#e63946\"] }",
    build: |source| {
        colour(source, "turbulence", |arguments, graph, main| fractal(arguments, graph, main, Fold::Turbulence))
    },
    ..Source::PLAIN
};
