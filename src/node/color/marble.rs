//! Veins of marble.

use crate::node::grain::{BY, GRAIN, WARP, colour, marble};
use crate::node::pattern::{COLOURS, DIRECTION, EASE, OCTAVES, SEED, SPACE, size};
use crate::node::source::Source;

/// Veins of marble.
pub const NODE: Source<3> = Source {
    key: size(
        "marble",
        "Veins across a direction, from 0 through 1 to 0 over this length, moved by a sum of octaves of noise. Veins finer than voxels fade to their mean.",
    ),
    parameters: &[DIRECTION, BY, WARP, GRAIN, OCTAVES, SEED, COLOURS, SPACE, EASE],
    formula: "½ − ½·cos 2π(d·p/a + w·(2n(p/g) − 1)), n a sum of octaves",
    example: "{ marble = 0.5, warp = 1.5, colors = [\"#f4f1ea\", \"#d9d3c7\", \"#4a4e57\"] }",
    build: |source| colour(source, "marble", marble),
    goes_by_coordinates: true,
    ..Source::PLAIN
};
