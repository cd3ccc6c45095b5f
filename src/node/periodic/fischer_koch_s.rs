//! Fischer and Koch's S surface.

use crate::node::minimal::{SHEET_OR_SOLID, Term, Wave::Cos, Wave::Sin, graded, surface};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// Fischer and Koch's S surface.
pub const NODE: Spec = Spec {
    key: Key::length(
        "fischer_koch_s",
        Required,
        "Fischer and Koch's S surface: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: SHEET_OR_SOLID,
    formula: "(t/2·|∇g| − |g|)/m for a sheet, (c − g)/m for a solid, m the mean of |∇g|, g = cos 2x sin y cos z + cos 2y sin z cos x + cos 2z sin x cos y, x, y, z in cells times 2π",
    source: "Fischer and Koch, 1987; its usual approximation by waves",
    example: "fischer_koch_s = 1\nthickness = 0.15\nbounds = { box = 2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| graded(build, grading, "fischer_koch_s", TERMS)),
    build: |build| surface(build, "fischer_koch_s", TERMS),
    ..Spec::PLAIN
};

/// g as a sum of products.
const TERMS: &[Term] = &[
    Term(1.0, &[Cos(0, 2), Sin(1, 1), Cos(2, 1)]),
    Term(1.0, &[Cos(1, 2), Sin(2, 1), Cos(0, 1)]),
    Term(1.0, &[Cos(2, 2), Sin(0, 1), Cos(1, 1)]),
];
