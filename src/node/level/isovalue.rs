//! The surface at another value of F.

use crate::node::spec::Spec;
use crate::text::key::Absent::Nothing;
use crate::text::key::{Key, Kind};

/// The surface at another value of F.
pub const NODE: Spec = Spec {
    key: Key::new(
        "isovalue",
        Kind::Number,
        Nothing,
        "The surface is where F has this value, not 0: of fields that are no distances, such as formulas. It is no distance \
         itself; `offset` is.",
    ),
    formula: "f − v",
    example: "formula = \"0.3/length(x - 0.5, y, z) + 0.3/length(x + 0.5, y, z)\"\nbounds = 3\nisovalue = 0.8",
    build: |build| {
        let value = build.number("isovalue")?;
        let solid = build.inner()?;
        Ok(build.graph().linear(solid, 1.0, -value))
    },
    ..Spec::PLAIN
};
