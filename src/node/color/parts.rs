//! The colours of other shapes.

use crate::node::source::{SEAM, Source, of_parts};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// The colours of other shapes.
pub const NODE: Source<3> = Source {
    key: Key::new(
        "parts",
        Kind::Shapes(1),
        Required,
        "Each part's colour inside of it, the later one's where parts overlap, and outside of all parts the mean \
         by the inverse of the distances to them. Parts stand in the shape's own space and do not change its form.",
    ),
    parameters: &[SEAM],
    formula: "Σ cⱼ/|fⱼ| / Σ 1/|fⱼ| outside (STTI, eq. 6)",
    example: "{ parts = [\"a\", \"b\"] }",
    build: of_parts,
    ..Source::PLAIN
};
