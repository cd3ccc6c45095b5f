//! Simplex noise.

use crate::field::Simplex;
use crate::node::pattern::{COLOURS, EASE, SEED, SPACE, colour, noise, size};
use crate::node::source::Source;

/// Simplex noise.
pub const NODE: Source<3> = Source {
    key: size("simplex", "Simplex noise, 0 to 1, in which no direction shows: the size of its cells."),
    parameters: &[SEED, COLOURS, SPACE, EASE],
    example: "{ simplex = 0.5, colors = [\"#1d3557\", \"#f1faee\", \"#e63946\"] }",
    build: |source| {
        colour(source, "simplex", |arguments, graph, main| noise(arguments, graph, main, |seed| Simplex { seed }))
    },
    ..Source::PLAIN
};
