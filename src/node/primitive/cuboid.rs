//! A box.

use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind, Limit};

/// A box.
pub const NODE: Spec = Spec {
    key: Key::new("box", Kind::Lengths, Required, "A box around the origin: its edge lengths; one number is a cube.")
        .limit(Limit::Positive)
        .unit("units"),
    formula: "the signed distance to it",
    example: "box = [1.6, 1.2, 0.8]",
    build: |build| {
        let edges = build.vector("box")?;
        Ok(build.graph().cuboid(edges))
    },
    ..Spec::PLAIN
};
