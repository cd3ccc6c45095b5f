//! The distance from the origin or the z axis.

use crate::node::pattern::{BETWEEN, number, radius, size};
use crate::node::source::Source;
use crate::text::key::Absent::Text;
use crate::text::key::{Key, Kind};

/// The distance from the origin or the z axis.
pub const NODE: Source<1> = Source {
    key: size("radius", "The distance from the origin or the z axis, 1 at this one."),
    parameters: &[
        Key::new("from", Kind::Choice(&["origin", "axis"]), Text("origin"), "What it is the distance from."),
        BETWEEN,
    ],
    example: "{ radius = 1 }",
    build: |source| number(source, "radius", radius),
    goes_by_coordinates: true,
    ..Source::PLAIN
};
