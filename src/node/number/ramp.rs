//! Numbers at stops of another number.

use crate::node::pattern::{BY, EASE, number_ramp};
use crate::node::source::Source;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// Numbers at stops of another number.
pub const NODE: Source<1> = Source {
    key: Key::new(
        "ramp",
        Kind::NumberStops,
        Required,
        "Numbers at stops of another number; the first and the last hold beyond.",
    ),
    parameters: &[BY, EASE],
    example: "{ ramp = [[-1, 0], [0, 0.2], [1, 1]], by = \"z\" }",
    build: number_ramp,
    ..Source::PLAIN
};
