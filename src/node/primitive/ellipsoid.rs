//! An ellipsoid.

use std::sync::Arc;

use crate::field::Ellipsoid;
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind, Limit};

/// An ellipsoid.
pub const NODE: Spec = Spec {
    key: Key::new("ellipsoid", Kind::Vector, Required, "An ellipsoid around the origin: its half axes.")
        .limit(Limit::Positive)
        .unit("units"),
    formula: "the signed distance to it, the nearest point found by iteration",
    source: "Eberly, Distance from a Point to an Ellipse, an Ellipsoid, or a Hyperellipsoid",
    example: "ellipsoid = [1, 0.7, 0.5]",
    build: |build| {
        let half = build.vector("ellipsoid")?;
        let graph = build.graph();
        if half.x == half.y && half.y == half.z {
            return Ok(graph.sphere(half.x));
        }
        Ok(graph.field(Arc::new(Ellipsoid::new(half.to_array()))))
    },
    ..Spec::PLAIN
};
