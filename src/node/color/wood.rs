//! Rings of wood.

use crate::node::grain::{AXIS, BY, EDGE, GRAIN, WARP, colour, wood};
use crate::node::pattern::{COLOURS, EASE, SEED, SPACE, size};
use crate::node::source::Source;

/// Rings of wood.
pub const NODE: Source<3> = Source {
    key: size(
        "wood",
        "Rings around an axis, from 0 to 1 outward through each and back: how thick a ring is. Rings finer than voxels fade to their mean.",
    ),
    parameters: &[AXIS, BY, WARP, GRAIN, EDGE, SEED, COLOURS, SPACE, EASE],
    formula: "fract(√(x² + y²)/a + w·(2·n(p/g) − 1)), n value noise; back to 0 over the last of each ring",
    example: "{ wood = 0.25, colors = [\"#6b3f1d\", \"#c98f56\", \"#e2b77f\"] }",
    build: |source| colour(source, "wood", wood),
    goes_by_coordinates: true,
    ..Source::PLAIN
};
