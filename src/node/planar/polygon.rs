//! A polygon.

use crate::field::Outline;
use crate::node::profile::{check_polygon, flat};
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// A polygon.
pub const NODE: Spec = Spec {
    key: Key::new(
        "polygon",
        Kind::Rows(3, &[2]),
        Required,
        "Polygon: its corners in order, either way round. Edges do not cross.",
    )
    .unit("units"),
    formula: "the signed distance to it",
    example: "polygon = [[-0.9, -0.7], [0.9, -0.7], [0.9, 0.7], [0.2, 0], [-0.9, 0.5]]",
    plane: Plane::Flat,
    build: |build| {
        let corners = build.plane_points("polygon");
        check_polygon(build, "polygon", &corners)?;
        Ok(flat(build, Outline::polygon(&corners)))
    },
    ..Spec::PLAIN
};
