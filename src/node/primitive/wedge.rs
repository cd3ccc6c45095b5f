//! A wedge: half of a box, cut along a diagonal.

use glam::{DVec2, DVec3};

use crate::field::Aabb;
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind, Limit};

/// A wedge: half of a box, cut along a diagonal.
pub const NODE: Spec = Spec {
    key: Key::new(
        "wedge",
        Kind::Lengths,
        Required,
        "Half of a box around the origin, which falls from the top at −x to the bottom at +x: the box's edge lengths.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    formula: "the signed distance to it",
    example: "wedge = [1.6, 1, 1]",
    build: |build| {
        let half = build.vector("wedge")? / 2.0;
        let graph = build.graph();
        let (x, z, width) = (graph.x(), graph.z(), graph.slab(DVec3::Y, 2.0 * half.y));
        let [low, far, high] = [(-half.x, -half.z), (half.x, -half.z), (-half.x, half.z)].map(DVec2::from);
        let profile = graph.convex_polygon([x, z], &[[low, far], [far, high], [high, low]]);
        let wedge = graph.corner(profile, width);
        Ok(graph.exact(wedge, Aabb::new(-half, half)))
    },
    ..Spec::PLAIN
};
