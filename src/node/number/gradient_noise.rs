//! Perlin noise.

use crate::field::GradientNoise;
use crate::node::pattern::{BETWEEN, SEED, noise, number, size};
use crate::node::source::Source;

/// Perlin noise.
pub const NODE: Source<1> = Source {
    key: size("gradient_noise", "Perlin noise, 0 to 1: the size of its cells."),
    parameters: &[SEED, BETWEEN],
    example: "{ gradient_noise = 0.4 }",
    build: |source| {
        number(source, "gradient_noise", |arguments, graph, main| {
            noise(arguments, graph, main, |seed| GradientNoise { seed })
        })
    },
    ..Source::PLAIN
};
