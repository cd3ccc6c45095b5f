//! F itself.

use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// F itself.
pub const NODE: Spec = Spec {
    key: Key::new(
        "formula",
        Kind::Formula,
        Required,
        "F itself, positive inside, of x, y, z, t, frame, time, pi and `[param]` names.",
    ),
    example: "formula = \"1 - x^4 - y^4 - z^4\"\nbounds = 3",
    is_endless: true,
    build: |build| {
        let formula = build.arguments().formula("formula").expect("it must be there").clone();
        let reading = build.reading(&formula)?;
        Ok(reading.node(build.graph()))
    },
    ..Spec::PLAIN
};
