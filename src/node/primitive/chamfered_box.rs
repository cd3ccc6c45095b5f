//! A box with chamfered edges.

use glam::DVec3;

use crate::field::Aabb;
use crate::node::profile::convex;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A box with chamfered edges.
pub const NODE: Spec = Spec {
    key: Key::new(
        "chamfered_box",
        Kind::Lengths,
        Required,
        "Box around the origin whose twelve edges are cut off at 45 degrees: its edge lengths; one number is a cube.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    parameters: &[Key::length("chamfer", Number(0.1), "How much of each face is cut off along an edge.")],
    formula: "the signed distance to it",
    example: "chamfered_box = [1.6, 1.2, 0.8]\nchamfer = 0.2",
    build: |build| {
        let (edges, chamfer) = (build.vector("chamfered_box")?, build.number("chamfer")?);
        if 2.0 * chamfer >= edges.min_element() {
            let most = edges.min_element() / 2.0;
            let problem = format!("`chamfer` must be less than half of the shortest edge, {most}");
            return Err(build.wrong("chamfer", problem).help("a smaller chamfer, or longer edges"));
        }
        // At each corner the three chamfers meet in a point, and two of them with each face.
        let half = edges / 2.0;
        let corners: Vec<DVec3> = Aabb::new(-DVec3::ONE, DVec3::ONE)
            .corners()
            .into_iter()
            .flat_map(|side| {
                let at = |cut: DVec3| side * (half - cut * chamfer);
                [at(DVec3::splat(0.5)), at(DVec3::ONE - DVec3::X), at(DVec3::ONE - DVec3::Y), at(DVec3::ONE - DVec3::Z)]
            })
            .collect();
        convex(build, "chamfered_box", &corners)
    },
    ..Spec::PLAIN
};
