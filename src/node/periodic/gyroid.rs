//! Schoen's gyroid.

use crate::node::minimal::{SHEET_OR_SOLID, Term, Wave::Cos, Wave::Sin, graded, surface};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// Schoen's gyroid.
pub const NODE: Spec = Spec {
    key: Key::length(
        "gyroid",
        Required,
        "Schoen's gyroid: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: SHEET_OR_SOLID,
    formula: "(t/2·|∇g| − |g|)/m for a sheet, (c − g)/m for a solid, m the mean of |∇g|, g = sin x cos y + sin y cos z + sin z cos x, x, y, z in cells times 2π",
    source: "Schoen, Infinite Periodic Minimal Surfaces without Self-Intersections, 1970; its usual approximation by waves",
    example: "gyroid = 1\nthickness = 0.15\nbounds = { box = 2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| graded(build, grading, "gyroid", TERMS)),
    build: |build| surface(build, "gyroid", TERMS),
    ..Spec::PLAIN
};

/// g as a sum of products.
const TERMS: &[Term] =
    &[Term(1.0, &[Sin(0, 1), Cos(1, 1)]), Term(1.0, &[Sin(1, 1), Cos(2, 1)]), Term(1.0, &[Sin(2, 1), Cos(0, 1)])];
