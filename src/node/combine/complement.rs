//! All that does not lie in a shape.

use crate::node::spec::{Carries, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// All that does not lie in a shape.
pub const NODE: Spec = Spec {
    key: Key::new("complement", Kind::Shape, Required, "All that does not lie in it. Unbounded: use it to cut."),
    formula: "−f",
    example: "complement = \"b\"\nbounds = { box = 2, cut = true }",
    carries: Carries::First,
    is_endless: true,
    build: |build| {
        let id = *build.arguments().shape("complement").expect("it must be there");
        let shape = build.shape(id)?;
        Ok(build.graph().neg(shape))
    },
    ..Spec::PLAIN
};
