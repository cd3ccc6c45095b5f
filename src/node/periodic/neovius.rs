//! Neovius' surface.

use crate::node::minimal::{SHEET_OR_SOLID, Term, Wave::Cos, graded, surface};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// Neovius' surface.
pub const NODE: Spec = Spec {
    key: Key::length(
        "neovius",
        Required,
        "Neovius' surface: the edge of a cell. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: SHEET_OR_SOLID,
    formula: "(t/2·|∇g| − |g|)/m for a sheet, (c − g)/m for a solid, m the mean of |∇g|, g = 3(cos x + cos y + cos z) + 4 cos x cos y cos z, x, y, z in cells times 2π",
    source: "Neovius, 1883; its usual approximation by waves",
    example: "neovius = 1\nthickness = 0.15\nbounds = { box = 2, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| graded(build, grading, "neovius", TERMS)),
    build: |build| surface(build, "neovius", TERMS),
    ..Spec::PLAIN
};

/// g as a sum of products.
const TERMS: &[Term] = &[
    Term(3.0, &[Cos(0, 1)]),
    Term(3.0, &[Cos(1, 1)]),
    Term(3.0, &[Cos(2, 1)]),
    Term(4.0, &[Cos(0, 1), Cos(1, 1), Cos(2, 1)]),
];
