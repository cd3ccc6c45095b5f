//! A shape and its mirror image.

use std::sync::Arc;

use glam::DVec3;

use crate::field::{Aabb, Graph, Node};
use crate::node::bend::Bend;
use crate::node::spec::Spec;
use crate::text::key::Absent::Nothing;
use crate::text::key::{Key, Kind};

/// The half on one side of a plane, and its mirror image.
pub const NODE: Spec = Spec {
    key: Key::new(
        "mirror",
        Kind::Choice(&["x", "y", "z"]),
        Nothing,
        "The half on the positive side of the plane through the origin, and its mirror image.",
    ),
    example: "sphere = 0.5\nat = { cells = \"c\" }\nmirror = \"x\"",
    bend: Some(|build| {
        let name = *build.arguments().choice("mirror").expect("it must be there");
        Ok(Arc::new(Fold(["x", "y", "z"].iter().position(|axis| *axis == name).unwrap_or(0))))
    }),
    ..Spec::PLAIN
};

/// Onto the positive half of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fold(pub usize);

impl Bend for Fold {
    fn node(&self, graph: &mut Graph, node: Node) -> Node {
        graph.mirror(node, DVec3::AXES[self.0], 0.0)
    }

    fn back(&self, position: DVec3) -> DVec3 {
        let mut folded = position;
        folded[self.0] = folded[self.0].abs();
        folded
    }

    fn region(&self, region: &Aabb) -> Aabb {
        let axis = self.0;
        let (a, b) = (region.min[axis].abs(), region.max[axis].abs());
        let mut folded = *region;
        (folded.min[axis], folded.max[axis]) = (a.min(b), a.max(b));
        // A region across the plane reaches down to it.
        if region.min[axis] < 0.0 && region.max[axis] > 0.0 {
            folded.min[axis] = 0.0;
        }
        folded
    }

    fn carried(&self, position: DVec3, mut vector: DVec3) -> DVec3 {
        if position[self.0] < 0.0 {
            vector[self.0] = -vector[self.0];
        }
        vector
    }
}
