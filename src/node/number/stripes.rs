//! Numbers in stripes.

use crate::attribute::Straight;
use crate::node::pattern::{DIRECTION, size, striped};
use crate::node::source::Source;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// Numbers in stripes.
pub const NODE: Source<1> = Source {
    key: size("stripes", "Stripes across a direction, each of this width."),
    parameters: &[Key::new("numbers", Kind::Numbers, Required, "Their numbers, over and over."), DIRECTION],
    example: "{ stripes = 0.2, numbers = [0, 1] }",
    build: |source| {
        let values = source.arguments().values("numbers").cloned().unwrap_or_default();
        let values: Vec<[f32; 1]> = values.into_iter().map(|value| [value]).collect();
        striped(source, "stripes", values, Straight)
    },
    goes_by_coordinates: true,
    ..Source::PLAIN
};
