//! A polygon turned about the z axis.

use crate::node::profile::{revolved, rounded_polygon};
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// A polygon turned about the z axis.
pub const NODE: Spec = Spec {
    key: Key::new(
        "lathe",
        Kind::Rows(3, &[2, 3]),
        Required,
        "Polygon turned about the z axis: its corners `[distance from the axis, z]`, or `[distance, z, radius]` where one is rounded, in order, either way round. An edge on the axis is inside.",
    )
    .unit("units"),
    formula: "the signed distance to it",
    example: "lathe = [[0, -0.9], [0.6, -0.9], [0.6, -0.8], [0.1, -0.7, 0.2], [0.1, -0.1, 0.3], [0.6, 0.3, 0.3], [0.5, 0.9], [0.45, 0.9], [0.5, 0.35], [0, 0]]",
    build: |build| {
        let corners = build.plane_points("lathe");
        if let Some(corner) = corners.iter().find(|corner| corner.x < 0.0) {
            let problem = format!("[{}, {}] lies beyond the axis", corner.x, corner.y);
            return Err(build.wrong("lathe", problem).help("the first number is the distance from the axis: at least 0"));
        }
        let outline = rounded_polygon(build, "lathe")?;
        Ok(revolved(build, outline))
    },
    ..Spec::PLAIN
};
