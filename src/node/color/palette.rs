//! One of a palette at random.

use crate::attribute::{Choice, Mixer};
use crate::node::source::{BY, EDGE, SEED, Source, at_random, has_pieces};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// One of a palette at random.
pub const NODE: Source<3> = Source {
    key: Key::new("palette", Kind::Palette, Required, "One of a palette's colours at random: its name, or colours."),
    parameters: &[BY, EDGE, SEED],
    example: "{ palette = [\"tomato\", \"gold\"], by = \"voxel\", voxel_size = 0.2 }",
    check: has_pieces,
    build: |source| {
        let colours = source.arguments().colours("palette").cloned().unwrap_or_default();
        at_random(source, Choice::<3, Mixer>::Palette(colours))
    },
    ..Source::PLAIN
};
