//! What lies in one of two shapes only.

use crate::node::spec::{Carries, Spec};
use crate::node::system::{ORDER, SYSTEM, system};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// What lies in one of two shapes only.
pub const NODE: Spec = Spec {
    key: Key::new(
        "symmetric_difference",
        Kind::Shapes(2),
        Required,
        "What lies in an odd number of them: of two, in one but not in both.",
    ),
    parameters: &[SYSTEM, ORDER],
    formula: "(a ∪ b) ∩ −(a ∩ b)",
    example: "symmetric_difference = [\"a\", \"b\"]",
    carries: Carries::Union,
    build: |build| {
        let shapes = build.shapes("symmetric_difference")?;
        let system = system(build)?;
        let graph = build.graph();
        let odd = shapes.into_iter().reduce(|a, b| {
            let (first, second) = (graph.difference(system, a, &[b]), graph.difference(system, b, &[a]));
            graph.union(system, &[first, second])
        });
        Ok(odd.unwrap_or_else(|| unreachable!("there are two operands")))
    },
    ..Spec::PLAIN
};
