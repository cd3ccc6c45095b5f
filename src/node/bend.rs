//! Maps of space that are not affine: one carries the field, the attributes and the motion of what is bent.

use glam::DVec3;

use crate::field::{Aabb, Graph, Node};

/// A map of a shape's space onto another.
pub trait Bend: Send + Sync {
    /// A node read through it.
    fn node(&self, graph: &mut Graph, node: Node) -> Node;
    /// Where a position comes from.
    fn back(&self, position: DVec3) -> DVec3;
    /// A box that holds all that a box comes from.
    fn region(&self, region: &Aabb) -> Aabb;
    /// A vector at the place that a position comes from, as it is at the position.
    fn carried(&self, position: DVec3, vector: DVec3) -> DVec3;
}
