//! The convex hull of points.

use crate::node::profile::convex;
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// The convex hull of points.
pub const NODE: Spec = Spec {
    key: Key::new(
        "hull",
        Kind::Rows(4, &[3]),
        Required,
        "Convex hull of points, at least four that do not lie in one plane.",
    )
    .unit("units"),
    formula: "the signed distance to it",
    example: "hull = [[1, 0, -0.7], [-0.5, 0.9, -0.7], [-0.5, -0.9, -0.7], [0.3, 0, 0.8], [-0.6, 0.2, 0.5]]",
    build: |build| {
        let points = build.points("hull");
        convex(build, "hull", &points)
    },
    ..Spec::PLAIN
};
