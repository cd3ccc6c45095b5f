//! Schoen's F-RD surface.

use crate::node::minimal::{SHEET_OR_SOLID, Term, Wave::Cos, graded, surface};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// Schoen's F-RD surface.
pub const NODE: Spec = Spec {
    key: Key::length(
        "f_rd",
        Required,
        "Schoen's F-RD surface: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    )
    .also(&["frd"]),
    parameters: SHEET_OR_SOLID,
    formula: "(t/2·|∇g| − |g|)/m for a sheet, (c − g)/m for a solid, m the mean of |∇g|, g = 4 cos x cos y cos z − cos 2x cos 2y − cos 2y cos 2z − cos 2z cos 2x, x, y, z in cells times 2π",
    source: "Schoen, Infinite Periodic Minimal Surfaces without Self-Intersections, 1970; its usual approximation by waves",
    example: "f_rd = 1\nthickness = 0.15\nbounds = { box = 2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| graded(build, grading, "f_rd", TERMS)),
    build: |build| surface(build, "f_rd", TERMS),
    ..Spec::PLAIN
};

/// g as a sum of products.
const TERMS: &[Term] = &[
    Term(4.0, &[Cos(0, 1), Cos(1, 1), Cos(2, 1)]),
    Term(-1.0, &[Cos(0, 2), Cos(1, 2)]),
    Term(-1.0, &[Cos(1, 2), Cos(2, 2)]),
    Term(-1.0, &[Cos(2, 2), Cos(0, 2)]),
];
