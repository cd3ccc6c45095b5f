//! Signed distances measured from a field's zero set: the band of a frame with closest points, and distance
//! objects that answer everywhere (HFRep: `papers: Hybrid Function Representation with Distance Properties`).

pub mod accuracy;
pub mod band;
mod block;
pub mod descent;
mod exchange;
pub mod extent;
mod facing;
pub mod nearest;
pub mod octree;
pub mod polish;
mod sampled;
mod staged;
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

/// A field whose value is the signed distance, and which also gives the foot.
pub trait Distance: Field {
    /// The closest surface point to any position.
    fn foot(&self, position: DVec3) -> Foot;
}
