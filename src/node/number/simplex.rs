//! Simplex noise.

use crate::field::Simplex;
use crate::node::pattern::{BETWEEN, SEED, noise, number, size};
use crate::node::source::Source;

/// Simplex noise.
pub const NODE: Source<1> = Source {
    key: size("simplex", "Simplex noise, 0 to 1, in which no direction shows: the size of its cells."),
    parameters: &[SEED, BETWEEN],
    example: "{ simplex = 0.5 }",
    build: |source| {
        number(source, "simplex", |arguments, graph, main| noise(arguments, graph, main, |seed| Simplex { seed }))
    },
    ..Source::PLAIN
};
