//! A shape pulled apart.

use std::sync::Arc;

use glam::DVec3;

use crate::field::Aabb;
use crate::node::bend::Mapped;
use crate::node::own_box::known_box;
use crate::node::spec::Spec;
use crate::text::key::Absent::Nothing;
use crate::text::key::{Key, Kind, Limit};

/// Pulled apart at the planes through the origin.
pub const NODE: Spec = Spec {
    key: Key::new(
        "elongate",
        Kind::Lengths,
        Nothing,
        "Pulled apart at the planes through the origin by these lengths along x, y and z: its sections there go on straight.",
    )
    .limit(Limit::NotNegative)
    .unit("units"),
    formula: "f(p − clamp(p, −h/2, h/2))",
    source: "Quilez, Distance functions: elongation",
    example: "torus = 0.4\ntube = 0.15\nelongate = [1, 0, 0.3]",
    bend: Some(|build| {
        let half = build.vector("elongate")? / 2.0;
        let solid = known_box(build)?.map(|own| Aabb::new(own.min - half, own.max + half));
        let map = Mapped::new(move |graph| {
            let coordinates = [graph.x(), graph.y(), graph.z()];
            std::array::from_fn(|axis| {
                let (coordinate, half) = (coordinates[axis], half[axis]);
                if half == 0.0 {
                    return coordinate;
                }
                // max(x − h, 0) + min(x + h, 0)
                let zero = graph.constant(0.0);
                let (less, more) = (graph.linear(coordinate, 1.0, -half), graph.linear(coordinate, 1.0, half));
                let (above, below) = (graph.max(less, zero), graph.min(more, zero));
                graph.add(above, below)
            })
        });
        Ok(Arc::new(Pulled { map: map.steepest(1.0).solid(solid), half }))
    }),
    ..Spec::PLAIN
};

/// Between the halves vectors along the pull have nowhere to come from.
struct Pulled {
    map: Mapped,
    half: DVec3,
}

impl crate::node::bend::Bend for Pulled {
    fn node(&self, graph: &mut crate::field::Graph, node: crate::field::Node) -> crate::field::Node {
        self.map.node(graph, node)
    }

    fn back(&self, position: DVec3) -> DVec3 {
        position - position.clamp(-self.half, self.half)
    }

    fn region(&self, region: &Aabb) -> Aabb {
        let back = |p: DVec3| p - p.clamp(-self.half, self.half);
        Aabb::new(back(region.min), back(region.max))
    }

    /// The section goes with the plane that it is a copy of.
    fn carried(&self, _position: DVec3, vector: DVec3) -> DVec3 {
        vector
    }
}
