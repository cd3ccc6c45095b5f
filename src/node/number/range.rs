//! Any number between two at random.

use crate::attribute::{Choice, Straight};
use crate::node::source::{BY, EDGE, SEED, Source, at_random, has_pieces};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// Any number between two at random.
pub const NODE: Source<1> = Source {
    key: Key::new("range", Kind::TwoNumbers, Required, "Any number between two at random: the two."),
    parameters: &[BY, EDGE, SEED],
    example: "{ range = [0, 1], by = \"voxel\", voxel_size = 0.2 }",
    check: has_pieces,
    build: |source| {
        let [from, to] = source.arguments().values("range").map_or(&[][..], |values| values)[..] else {
            unreachable!("a range has two ends")
        };
        at_random(source, Choice::Range { from: [from], to: [to], mix: Straight })
    },
    ..Source::PLAIN
};
