//! Colours at stops of a number.

use crate::node::pattern::{BY, EASE, SPACE, colour_ramp};
use crate::node::source::Source;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// Colours at stops of a number.
pub const NODE: Source<3> = Source {
    key: Key::new("ramp", Kind::Stops, Required, "Colours at stops of a number; the first and the last hold beyond."),
    parameters: &[BY, EASE, SPACE],
    example: "{ ramp = [[-1, \"navy\"], [0, \"white\"], [1, \"gold\"]], by = \"z + 0.3*fbm(3*x, 3*y, 3*z, 4)\" }",
    build: colour_ramp,
    ..Source::PLAIN
};
