//! Maps of space that are not affine: one carries the field, the attributes and the motion of what is bent.

use glam::DVec3;

use crate::field::{Aabb, Graph, Node, Points};

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

    /// Where a batch comes from.
    fn points_back(&self, points: &Points, out: &mut Points) {
        (out.origin, out.len) = (self.back(points.origin), 0);
        for i in 0..points.len {
            out.push((self.back(points.position(i)) - out.origin).as_vec3());
        }
    }

    /// The vectors at the places that a batch comes from, as they are at the batch.
    fn vectors_carried(&self, points: &Points, vectors: &mut [[f32; 3]]) {
        for (i, vector) in vectors.iter_mut().enumerate().take(points.len) {
            let carried = self.carried(points.position(i), DVec3::from_array(vector.map(f64::from)));
            *vector = carried.as_vec3().to_array();
        }
    }
}
