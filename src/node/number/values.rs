//! One of some numbers at random.

use crate::attribute::{Choice, Straight};
use crate::node::source::{BY, EDGE, SEED, Source, at_random, has_pieces};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// One of some numbers at random.
pub const NODE: Source<1> = Source {
    key: Key::new("values", Kind::Numbers, Required, "One of these numbers at random."),
    parameters: &[BY, EDGE, SEED],
    example: "{ values = [0.1, 0.5, 0.9], by = \"voxel\", voxel_size = 0.2 }",
    check: has_pieces,
    build: |source| {
        let values = source.arguments().values("values").cloned().unwrap_or_default();
        at_random(source, Choice::<1, Straight>::Palette(values.into_iter().map(|value| [value]).collect()))
    },
    ..Source::PLAIN
};
