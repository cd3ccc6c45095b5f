//! An ellipsoid.

use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind, Limit};

/// An ellipsoid.
pub const NODE: Spec = Spec {
    key: Key::new("ellipsoid", Kind::Vector, Required, "An ellipsoid around the origin: its half axes.")
        .limit(Limit::Positive)
        .unit("units"),
    formula: "(1 − |(x/a, y/b, z/c)|)·min(a, b, c)",
    example: "ellipsoid = [1, 0.7, 0.5]",
    build: |build| {
        let half_axes = build.vector("ellipsoid")?;
        Ok(build.graph().ellipsoid(half_axes))
    },
    ..Spec::PLAIN
};
