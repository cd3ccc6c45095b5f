//! Schwarz' P surface.

use crate::node::minimal::{SHEET_OR_SOLID, Term, Wave::Cos, graded, surface};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// Schwarz' P surface.
pub const NODE: Spec = Spec {
    key: Key::length(
        "schwarz_p",
        Required,
        "Schwarz' P surface: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    )
    .also(&["schwarz_primitive"]),
    parameters: SHEET_OR_SOLID,
    formula: "(t/2·|∇g| − |g|)/m for a sheet, (c − g)/m for a solid, m the mean of |∇g|, g = cos x + cos y + cos z, x, y, z in cells times 2π",
    source: "Schwarz, 1865; its usual approximation by waves",
    example: "schwarz_p = 1\nthickness = 0.15\nbounds = { box = 2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| graded(build, grading, "schwarz_p", TERMS)),
    build: |build| surface(build, "schwarz_p", TERMS),
    ..Spec::PLAIN
};

/// g as a sum of products.
const TERMS: &[Term] = &[Term(1.0, &[Cos(0, 1)]), Term(1.0, &[Cos(1, 1)]), Term(1.0, &[Cos(2, 1)])];
