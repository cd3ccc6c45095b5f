//! The split P surface.

use crate::node::minimal::{SHEET_OR_SOLID, Term, Wave::Cos, Wave::Sin, graded, surface};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// The split P surface.
pub const NODE: Spec = Spec {
    key: Key::length(
        "split_p",
        Required,
        "Split P surface: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: SHEET_OR_SOLID,
    formula: "(t/2·|∇g| − |g|)/m for a sheet, (c − g)/m for a solid, m the mean of |∇g|, g = 1.1(sin 2x cos y sin z + sin 2y cos z sin x + sin 2z cos x sin y) − 0.2(cos 2x cos 2y + cos 2y cos 2z + cos 2z cos 2x) − 0.4(cos 2x + cos 2y + cos 2z), x, y, z in cells times 2π",
    source: "Fogden and Hyde; its usual approximation by waves",
    example: "split_p = 1\nthickness = 0.15\nbounds = { box = 2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| graded(build, grading, "split_p", TERMS)),
    build: |build| surface(build, "split_p", TERMS),
    ..Spec::PLAIN
};

/// g as a sum of products.
const TERMS: &[Term] = &[
    Term(1.1, &[Sin(0, 2), Cos(1, 1), Sin(2, 1)]),
    Term(1.1, &[Sin(1, 2), Cos(2, 1), Sin(0, 1)]),
    Term(1.1, &[Sin(2, 2), Cos(0, 1), Sin(1, 1)]),
    Term(-0.2, &[Cos(0, 2), Cos(1, 2)]),
    Term(-0.2, &[Cos(1, 2), Cos(2, 2)]),
    Term(-0.2, &[Cos(2, 2), Cos(0, 2)]),
    Term(-0.4, &[Cos(0, 2)]),
    Term(-0.4, &[Cos(1, 2)]),
    Term(-0.4, &[Cos(2, 2)]),
];
