//! The angle about an axis.

use crate::node::pattern::{BETWEEN, angle, number};
use crate::node::source::Source;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// The angle about an axis.
pub const NODE: Source<1> = Source {
    key: Key::new(
        "angle",
        Kind::Choice(&["x", "y", "z"]),
        Required,
        "The angle about this axis as a share of a whole turn, 0 to 1.",
    ),
    parameters: &[BETWEEN],
    example: "{ angle = \"z\" }",
    build: |source| number(source, "angle", angle),
    goes_by_coordinates: true,
    ..Source::PLAIN
};
