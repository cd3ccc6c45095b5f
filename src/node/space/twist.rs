//! A shape turned about z, the more the higher.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::field::{Aabb, Graph, Node};
use crate::node::bend::Bend;
use crate::node::spec::Spec;
use crate::text::key::Absent::Nothing;
use crate::text::key::{Key, Kind};

/// Turned about z, the more the higher.
pub const NODE: Spec = Spec {
    key: Key::new(
        "twist",
        Kind::Number,
        Nothing,
        "Turns each level about z, the more the higher: by how much a unit of z.",
    )
    .unit("degrees"),
    formula: "f(R(−k·z)·p)",
    example: "box = [0.8, 0.8, 2]\ntwist = 60",
    bend: Some(|build| Ok(Arc::new(Twist(build.number("twist")?.to_radians())))),
    ..Spec::PLAIN
};

/// Radians a unit of z.
struct Twist(f64);

impl Bend for Twist {
    fn node(&self, graph: &mut Graph, node: Node) -> Node {
        let (x, y, z) = (graph.x(), graph.y(), graph.z());
        let angle = graph.linear(z, self.0, 0.0);
        let (sin, cos) = (graph.sin(angle), graph.cos(angle));
        let [xc, ys, yc, xs] = [(x, cos), (y, sin), (y, cos), (x, sin)].map(|(a, b)| graph.mul(a, b));
        let back = [graph.add(xc, ys), graph.sub(yc, xs), z];
        let twisted = graph.warp(node, back);
        match graph.known_box(node) {
            Some(aabb) => graph.bounded(twisted, self.region(&aabb)),
            None => twisted,
        }
    }

    fn back(&self, position: DVec3) -> DVec3 {
        DMat3::from_rotation_z(-self.0 * position.z) * position
    }

    fn region(&self, region: &Aabb) -> Aabb {
        let far = region.min.abs().max(region.max.abs());
        let reach = far.x.hypot(far.y);
        Aabb::new(DVec3::new(-reach, -reach, region.min.z), DVec3::new(reach, reach, region.max.z))
    }

    fn forth(&self, own: DVec3, _branch: u32) -> Option<DVec3> {
        Some(DMat3::from_rotation_z(self.0 * own.z) * own)
    }

    fn carried(&self, position: DVec3, vector: DVec3) -> DVec3 {
        let turned = DMat3::from_rotation_z(self.0 * position.z) * vector;
        turned + self.0 * vector.z * DVec3::Z.cross(position)
    }
}
