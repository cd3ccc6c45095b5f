//! What is in all of several shapes.

use crate::node::spec::{Carries, Spec};
use crate::node::system::{ORDER, SYSTEM, system};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// What is in all of several shapes.
pub const NODE: Spec = Spec {
    key: Key::new("intersection", Kind::Shapes(1), Required, "What lies in all of them."),
    parameters: &[SYSTEM, ORDER],
    formula: "a + b − √(a² + b²)",
    source: "R₀ of Rvachev's R-functions",
    example: "intersection = [\"a\", \"b\"]",
    carries: Carries::Any,
    build: |build| {
        let shapes = build.different_shapes("intersection")?;
        let system = system(build)?;
        Ok(build.graph().intersection(system, &shapes))
    },
    ..Spec::PLAIN
};
