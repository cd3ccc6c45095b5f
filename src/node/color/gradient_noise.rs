//! Perlin noise.

use crate::field::GradientNoise;
use crate::node::pattern::{COLOURS, EASE, SEED, SPACE, colour, noise, size};
use crate::node::source::Source;

/// Perlin noise.
pub const NODE: Source<3> = Source {
    key: size("gradient_noise", "Perlin noise, 0 to 1: the size of its cells."),
    parameters: &[SEED, COLOURS, SPACE, EASE],
    example: "{ gradient_noise = 0.4, colors = [\"#1d3557\", \"#f1faee\", \"#e63946\"] }",
    build: |source| {
        colour(source, "gradient_noise", |arguments, graph, main| {
            noise(arguments, graph, main, |seed| GradientNoise { seed })
        })
    },
    ..Source::PLAIN
};
