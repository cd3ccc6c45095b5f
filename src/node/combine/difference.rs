//! A shape without others.

use crate::node::spec::{Carries, Spec};
use crate::node::system::{ORDER, SYSTEM, system};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// A shape without others.
pub const NODE: Spec = Spec {
    key: Key::new("difference", Kind::Shapes(2), Required, "The first without all others."),
    parameters: &[SYSTEM, ORDER],
    formula: "a − b − √(a² + b²)",
    source: "R₀ of Rvachev's R-functions",
    example: "difference = [\"a\", \"b\"]",
    carries: Carries::First,
    build: |build| {
        let shapes = build.shapes("difference")?;
        let system = system(build)?;
        Ok(build.graph().difference(system, shapes[0], &shapes[1..]))
    },
    ..Spec::PLAIN
};
