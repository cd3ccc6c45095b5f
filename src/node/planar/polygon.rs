//! A polygon.

use crate::node::profile::{flat, rounded_polygon};
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// A polygon.
pub const NODE: Spec = Spec {
    key: Key::new(
        "polygon",
        Kind::Rows(3, &[2, 3]),
        Required,
        "Polygon: its corners in order, either way round, each `[x, y]`, or `[x, y, radius]` where it is rounded. Edges do not cross.",
    )
    .unit("units"),
    formula: "the signed distance to it",
    example: "polygon = [[-0.9, -0.7], [0.9, -0.7], [0.9, 0.7], [0.2, 0], [-0.9, 0.5, 0.2]]",
    plane: Plane::Flat,
    build: |build| {
        let outline = rounded_polygon(build, "polygon")?;
        Ok(flat(build, outline))
    },
    ..Spec::PLAIN
};
