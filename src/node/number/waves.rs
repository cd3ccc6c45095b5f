//! Waves.

use crate::node::pattern::{BETWEEN, DIRECTION, number, size, waves};
use crate::node::source::Source;

/// Waves.
pub const NODE: Source<1> = Source {
    key: size("waves", "Waves along a direction, from 0 through 1 to 0 over this length."),
    parameters: &[DIRECTION, BETWEEN],
    example: "{ waves = 0.3 }",
    build: |source| number(source, "waves", waves),
    goes_by_coordinates: true,
    ..Source::PLAIN
};
