//! Schoen's I-WP surface.

use crate::node::minimal::{SHEET_OR_SOLID, Term, Wave::Cos, graded, surface};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// Schoen's I-WP surface.
pub const NODE: Spec = Spec {
    key: Key::length(
        "i_wp",
        Required,
        "Schoen's I-WP surface: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    )
    .also(&["iwp"]),
    parameters: SHEET_OR_SOLID,
    formula: "(t/2·|∇g| − |g|)/m for a sheet, (c − g)/m for a solid, m the mean of |∇g|, g = 2(cos x cos y + cos y cos z + cos z cos x) − cos 2x − cos 2y − cos 2z, x, y, z in cells times 2π",
    source: "Schoen, Infinite Periodic Minimal Surfaces without Self-Intersections, 1970; its usual approximation by waves",
    example: "i_wp = 1\nthickness = 0.15\nbounds = { box = 2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| graded(build, grading, "i_wp", TERMS)),
    build: |build| surface(build, "i_wp", TERMS),
    ..Spec::PLAIN
};

/// g as a sum of products.
const TERMS: &[Term] = &[
    Term(2.0, &[Cos(0, 1), Cos(1, 1)]),
    Term(2.0, &[Cos(1, 1), Cos(2, 1)]),
    Term(2.0, &[Cos(2, 1), Cos(0, 1)]),
    Term(-1.0, &[Cos(0, 2)]),
    Term(-1.0, &[Cos(1, 2)]),
    Term(-1.0, &[Cos(2, 2)]),
];
