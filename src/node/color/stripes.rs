//! Colours in stripes.

use crate::attribute::{ColourSpace, Mixer};
use crate::node::pattern::{COLOURS, DIRECTION, size, striped};
use crate::node::source::Source;

/// Colours in stripes.
pub const NODE: Source<3> = Source {
    key: size("stripes", "Stripes across a direction, each of this width."),
    parameters: &[COLOURS, DIRECTION],
    example: "{ stripes = 0.2, colors = [\"#e63946\", \"white\"] }",
    build: |source| {
        let colours = source.arguments().colours("colors").cloned().unwrap_or_default();
        let first = colours.first().copied().unwrap_or_default();
        // Stripes have sharp edges: nothing is mixed.
        let mix = Mixer::between(ColourSpace::Rgb, first, first);
        striped(source, "stripes", colours, mix)
    },
    goes_by_coordinates: true,
    ..Source::PLAIN
};
