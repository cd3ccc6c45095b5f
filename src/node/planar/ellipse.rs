//! An ellipse.

use std::sync::Arc;

use crate::field::Ellipse;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind, Limit};

/// An ellipse.
pub const NODE: Spec = Spec {
    key: Key::new("ellipse", Kind::Pair, Required, "Ellipse around the origin: its half axes along x and y.")
        .limit(Limit::Positive)
        .unit("units"),
    formula: "the signed distance to it, the nearest point found by iteration",
    source: "Eberly, Distance from a Point to an Ellipse, an Ellipsoid, or a Hyperellipsoid",
    example: "ellipse = [1, 0.6]",
    plane: Plane::Flat,
    build: |build| {
        let half = build.pair("ellipse")?;
        Ok(build.graph().field(Arc::new(Ellipse::new(half.to_array()))))
    },
    ..Spec::PLAIN
};
