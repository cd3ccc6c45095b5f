//! Colours by depth.

use crate::node::source::{Source, by_depth};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// Colours by depth.
pub const NODE: Source<3> = Source {
    key: Key::new(
        "bands",
        Kind::Bands,
        Required,
        "Colours by depth below the shape's surface (outside: negative), in its own space before `scale`. Each \
         begins at its depth; what lies before the first has the first's. They show where something cuts into \
         the shape.",
    )
    .unit("units"),
    example: "{ bands = [[0.0, \"white\"], [0.1, \"#aa3311\"]] }",
    build: |source| {
        let bands = source.arguments().bands("bands").cloned().unwrap_or_default();
        by_depth(source, bands)
    },
    ..Source::PLAIN
};
