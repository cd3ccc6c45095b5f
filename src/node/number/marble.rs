//! Veins of marble.

use crate::node::grain::{BY, GRAIN, WARP, marble, number};
use crate::node::pattern::{BETWEEN, DIRECTION, OCTAVES, SEED, size};
use crate::node::source::Source;

/// Veins of marble.
pub const NODE: Source<1> = Source {
    key: size(
        "marble",
        "Veins across a direction, from 0 through 1 to 0 over this length, moved by a sum of octaves of noise. Veins finer than voxels fade to their mean.",
    ),
    parameters: &[DIRECTION, BY, WARP, GRAIN, OCTAVES, SEED, BETWEEN],
    formula: "½ − ½·cos 2π(d·p/a + w·(2n(p/g) − 1)), n a sum of octaves",
    example: "{ marble = 0.5, warp = 1.5 }",
    build: |source| number(source, "marble", marble),
    goes_by_coordinates: true,
    ..Source::PLAIN
};
