//! All in any of several shapes.

use crate::field::SetSystem;
use crate::node::source::SEAM;
use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// All in any of several shapes.
pub const NODE: Spec = Spec {
    key: Key::new(
        "union",
        Kind::Shapes(1),
        Required,
        "All that lies in any of them. Where they overlap, the later one's colour.",
    ),
    parameters: &[SEAM],
    formula: "a + b + √(a² + b²)",
    source: "R₀ of Rvachev's R-functions",
    example: "union = [\"a\", \"b\"]",
    carries: Carries::Union,
    build: |build| {
        let shapes = build.different_shapes("union")?;
        Ok(build.graph().union(SetSystem::R0, &shapes))
    },
    ..Spec::PLAIN
};
