//! Noise with crests.

use crate::field::Fold;
use crate::node::pattern::{COLOURS, EASE, OCTAVES, SEED, SPACE, colour, fractal, size};
use crate::node::source::Source;

/// Noise with crests.
pub const NODE: Source<3> = Source {
    key: size("ridged", "A sum of octaves of noise folded to crests, 0 to 1: the size of the largest cells."),
    parameters: &[OCTAVES, SEED, COLOURS, SPACE, EASE],
    example: "{ ridged = 0.6, colors = [\"#1d3557\", \"#f1faee\", \"#e63946\"] }",
    build: |source| colour(source, "ridged", |arguments, graph, main| fractal(arguments, graph, main, Fold::Ridged)),
    ..Source::PLAIN
};
