//! Any colour between two at random.

use crate::attribute::{Choice, ColourSpace, Mixer};
use crate::node::keys::COLOUR_SPACES;
use crate::node::source::{BY, EDGE, SEED, Source, at_random, has_pieces};
use crate::text::key::Absent::{Required, Text};
use crate::text::key::{Key, Kind};

/// Any colour between two at random.
pub const NODE: Source<3> = Source {
    key: Key::new("range", Kind::TwoColours, Required, "Any colour between two at random: the two."),
    parameters: &[
        BY,
        EDGE,
        SEED,
        Key::new("color_space", Kind::Choice(COLOUR_SPACES), Text("oklab"), "The space that they are mixed in.")
            .also(&["colour_space"]),
    ],
    example: "{ range = [\"navy\", \"white\"], by = \"voxel\", voxel_size = 0.2 }",
    check: has_pieces,
    build: |source| {
        let arguments = source.arguments();
        let space = arguments.choice("color_space").and_then(|name| ColourSpace::named(name)).expect("a known space");
        let [from, to] = arguments.colours("range").map_or(&[][..], |colours| colours)[..] else {
            unreachable!("a range has two ends")
        };
        at_random(source, Choice::Range { from, to, mix: Mixer::between(space, from, to) })
    },
    ..Source::PLAIN
};
