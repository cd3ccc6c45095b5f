//! Lidin's surface.

use crate::node::minimal::{SHEET_OR_SOLID, Term, Wave::Cos, Wave::Sin, graded, surface};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// Lidin's surface.
pub const NODE: Spec = Spec {
    key: Key::length(
        "lidinoid",
        Required,
        "Lidin's surface: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: SHEET_OR_SOLID,
    formula: "(t/2·|∇g| − |g|)/m for a sheet, (c − g)/m for a solid, m the mean of |∇g|, g = (sin 2x cos y sin z + sin 2y cos z sin x + sin 2z cos x sin y)/2 − (cos 2x cos 2y + cos 2y cos 2z + cos 2z cos 2x)/2 + 0.15, x, y, z in cells times 2π",
    source: "Lidin and Larsson, 1990; its usual approximation by waves",
    example: "lidinoid = 1\nthickness = 0.15\nbounds = { box = 2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| graded(build, grading, "lidinoid", TERMS)),
    build: |build| surface(build, "lidinoid", TERMS),
    ..Spec::PLAIN
};

/// g as a sum of products.
const TERMS: &[Term] = &[
    Term(0.5, &[Sin(0, 2), Cos(1, 1), Sin(2, 1)]),
    Term(0.5, &[Sin(1, 2), Cos(2, 1), Sin(0, 1)]),
    Term(0.5, &[Sin(2, 2), Cos(0, 1), Sin(1, 1)]),
    Term(-0.5, &[Cos(0, 2), Cos(1, 2)]),
    Term(-0.5, &[Cos(1, 2), Cos(2, 2)]),
    Term(-0.5, &[Cos(2, 2), Cos(0, 2)]),
    Term(0.15, &[]),
];
