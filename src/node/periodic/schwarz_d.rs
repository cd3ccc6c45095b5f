//! Schwarz' D surface.

use crate::node::minimal::{SHEET_OR_SOLID, Term, Wave::Cos, Wave::Sin, graded, surface};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// Schwarz' D surface.
pub const NODE: Spec = Spec {
    key: Key::length(
        "schwarz_d",
        Required,
        "Schwarz' D surface: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    )
    .also(&["schwarz_diamond"]),
    parameters: SHEET_OR_SOLID,
    formula: "(t/2·|∇g| − |g|)/m for a sheet, (c − g)/m for a solid, m the mean of |∇g|, g = sin x sin y sin z + sin x cos y cos z + cos x sin y cos z + cos x cos y sin z, x, y, z in cells times 2π",
    source: "Schwarz, 1865; its usual approximation by waves",
    example: "schwarz_d = 1\nthickness = 0.15\nbounds = { box = 2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| graded(build, grading, "schwarz_d", TERMS)),
    build: |build| surface(build, "schwarz_d", TERMS),
    ..Spec::PLAIN
};

/// g as a sum of products.
const TERMS: &[Term] = &[
    Term(1.0, &[Sin(0, 1), Sin(1, 1), Sin(2, 1)]),
    Term(1.0, &[Sin(0, 1), Cos(1, 1), Cos(2, 1)]),
    Term(1.0, &[Sin(1, 1), Cos(2, 1), Cos(0, 1)]),
    Term(1.0, &[Sin(2, 1), Cos(0, 1), Cos(1, 1)]),
];
