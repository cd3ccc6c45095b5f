//! All in any of several shapes.

use crate::node::source::SEAM;
use crate::node::spec::{Carries, Spec};
use crate::node::system::{ORDER, SYSTEM, system};
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
    parameters: &[SEAM, SYSTEM, ORDER],
    formula: "a + b + √(a² + b²)",
    source: "R₀ of Rvachev's R-functions",
    example: "union = [\"a\", \"b\"]",
    carries: Carries::Union,
    build: |build| {
        let shapes = build.different_shapes("union")?;
        let system = system(build)?;
        Ok(build.graph().union(system, &shapes))
    },
    ..Spec::PLAIN
};
