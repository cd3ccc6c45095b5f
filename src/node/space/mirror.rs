//! A shape and its mirror image.

use std::sync::Arc;

use glam::DVec3;

use crate::field::{Aabb, Graph, Node};
use crate::node::bend::{Bend, around};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Nothing, Number};
use crate::text::key::{Key, Kind};

/// The half on one side of a plane, and its mirror image.
pub const NODE: Spec = Spec {
    key: Key::new(
        "mirror",
        Kind::Direction,
        Nothing,
        "The half on the side of a plane that this direction points to, and its mirror image.",
    ),
    parameters: &[
        Key::new("mirror_offset", Kind::Number, Number(0.0), "How far the plane is from the origin.").unit("units")
    ],
    formula: "f(p + (|h| − h)·n), h = n·p − o",
    example: "box = [0.5, 0.3, 0.8]\ndo = [{ move = [0.4, 0.1, 0.2] }, { mirror = [1, 1, 0] }]",
    bend: Some(|build| {
        let (normal, offset) = (build.direction("mirror")?.normalize(), build.number("mirror_offset")?);
        let axis = DVec3::AXES.into_iter().position(|axis| axis == normal);
        Ok(match axis.filter(|_| offset == 0.0) {
            Some(axis) => Arc::new(Fold(axis)),
            None => Arc::new(Reflected { normal, offset }),
        })
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

    fn branch(&self, position: DVec3) -> u32 {
        u32::from(position[self.0] < 0.0)
    }

    fn forth(&self, own: DVec3, branch: u32) -> Option<DVec3> {
        let mut there = own;
        if branch == 1 {
            there[self.0] = -there[self.0];
        }
        Some(there)
    }

    fn carried(&self, position: DVec3, mut vector: DVec3) -> DVec3 {
        if position[self.0] < 0.0 {
            vector[self.0] = -vector[self.0];
        }
        vector
    }
}

/// Onto the upper side of any plane.
struct Reflected {
    normal: DVec3,
    offset: f64,
}

impl Reflected {
    fn height(&self, position: DVec3) -> f64 {
        self.normal.dot(position) - self.offset
    }

    fn image(&self, position: DVec3) -> DVec3 {
        position - self.normal * (2.0 * self.height(position))
    }
}

impl Bend for Reflected {
    fn node(&self, graph: &mut Graph, node: Node) -> Node {
        graph.mirror(node, self.normal, self.offset)
    }

    fn back(&self, position: DVec3) -> DVec3 {
        if self.height(position) < 0.0 { self.image(position) } else { position }
    }

    fn region(&self, region: &Aabb) -> Aabb {
        let corners = region.corners();
        let images = around(corners.map(|corner| self.image(corner)));
        let below = corners.iter().filter(|corner| self.height(**corner) < 0.0).count();
        match below {
            0 => *region,
            8 => images,
            _ => region.union(images),
        }
    }

    fn branch(&self, position: DVec3) -> u32 {
        u32::from(self.height(position) < 0.0)
    }

    fn forth(&self, own: DVec3, branch: u32) -> Option<DVec3> {
        Some(if branch == 1 { self.image(own) } else { own })
    }

    fn carried(&self, position: DVec3, vector: DVec3) -> DVec3 {
        if self.height(position) < 0.0 { vector - self.normal * (2.0 * self.normal.dot(vector)) } else { vector }
    }
}
