//! The scalars of other shapes.

use crate::node::source::{SEAM, Source, of_parts};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// The scalars of other shapes.
pub const NODE: Source<1> = Source {
    key: Key::new(
        "parts",
        Kind::Shapes(1),
        Required,
        "What the attribute of the same name is on each of these shapes, as colours have them; 0 on those without it.",
    ),
    parameters: &[SEAM],
    formula: "Σ aⱼ/|fⱼ| / Σ 1/|fⱼ| outside (STTI, eq. 6)",
    example: "{ parts = [\"a\", \"b\"] }",
    build: of_parts,
    ..Source::PLAIN
};
