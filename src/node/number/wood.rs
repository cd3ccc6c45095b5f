//! Rings of wood.

use crate::node::grain::{AXIS, BY, EDGE, GRAIN, WARP, number, wood};
use crate::node::pattern::{BETWEEN, SEED, size};
use crate::node::source::Source;

/// Rings of wood.
pub const NODE: Source<1> = Source {
    key: size(
        "wood",
        "Rings around an axis, from 0 to 1 outward through each and back: how thick a ring is. Rings finer than voxels fade to their mean.",
    ),
    parameters: &[AXIS, BY, WARP, GRAIN, EDGE, SEED, BETWEEN],
    formula: "fract(√(x² + y²)/a + w·(2·n(p/g) − 1)), n value noise; back to 0 over the last of each ring",
    example: "{ wood = 0.25 }",
    build: |source| number(source, "wood", wood),
    goes_by_coordinates: true,
    ..Source::PLAIN
};
