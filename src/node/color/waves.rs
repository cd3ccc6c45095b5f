//! Waves.

use crate::node::pattern::{COLOURS, DIRECTION, EASE, SPACE, colour, size, waves};
use crate::node::source::Source;

/// Waves.
pub const NODE: Source<3> = Source {
    key: size("waves", "Waves along a direction, from 0 through 1 to 0 over this length."),
    parameters: &[DIRECTION, COLOURS, SPACE, EASE],
    example: "{ waves = 0.3, colors = [\"#1d3557\", \"#f1faee\", \"#e63946\"] }",
    build: |source| colour(source, "waves", waves),
    goes_by_coordinates: true,
    ..Source::PLAIN
};
