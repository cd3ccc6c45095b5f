//! The angle about an axis.

use crate::node::pattern::{COLOURS, EASE, SPACE, angle, colour};
use crate::node::source::Source;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// The angle about an axis.
pub const NODE: Source<3> = Source {
    key: Key::new(
        "angle",
        Kind::Choice(&["x", "y", "z"]),
        Required,
        "The angle about this axis as a share of a whole turn, 0 to 1.",
    ),
    parameters: &[COLOURS, SPACE, EASE],
    example: "{ angle = \"z\", colors = [\"#1d3557\", \"#f1faee\", \"#e63946\"] }",
    build: |source| colour(source, "angle", angle),
    goes_by_coordinates: true,
    ..Source::PLAIN
};
