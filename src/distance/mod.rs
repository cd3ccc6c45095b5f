//! Signed distances measured from a field's zero set: the band of a frame with closest points, and distance
//! objects that answer everywhere (HFRep: `papers: Hybrid Function Representation with Distance Properties`).

pub mod accuracy;
pub mod band;
mod block;
pub mod descent;
mod exchange;
pub mod extent;
mod facing;
pub mod method;
pub mod nearest;
pub mod octree;
pub mod outline;
pub mod outlined;
pub mod polish;
pub mod quadtree;
mod sampled;
mod staged;
pub mod step;
pub mod without;

#[cfg(test)]
mod testing;

pub use sampled::SampledLevelSet;

use glam::DVec3;

use crate::field::Field;

/// The closest surface point to a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// The closest point on the surface, world units.
    pub point: DVec3,
    /// Signed distance to it, world units, positive inside.
    pub distance: f64,
    /// ∇F of unit length at the position, pointing inward: `position − distance·gradient = point`. On the surface
    /// itself it is the inward normal.
    pub gradient: DVec3,
    /// Which part or triangle the foot lies on; 0 where there is only one.
    pub part: u32,
}

/// A field whose value is the signed distance to its zero set.
pub trait Distance: Field {
    /// The closest point of the zero set to each position, where the distance comes from closest points and knows them;
    /// else `false`, and `closest` stays as it is. It has the length of `positions`.
    fn closest_points(&self, positions: &[DVec3], closest: &mut [Foot]) -> bool;
}
