//! Numbers by depth.

use crate::node::source::{Source, by_depth};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// Numbers by depth.
pub const NODE: Source<1> = Source {
    key: Key::new(
        "bands",
        Kind::NumberBands,
        Required,
        "Numbers by depth below the shape's surface, as colours have them.",
    )
    .unit("units"),
    example: "{ bands = [[0.0, 0.2], [0.1, 0.9]] }",
    build: |source| {
        let bands = source.arguments().number_bands("bands").cloned().unwrap_or_default();
        by_depth(source, bands)
    },
    ..Source::PLAIN
};
