//! What a solid of many parts says of each.

use glam::DVec3;

use super::{Aabb, Slope};

/// How far a region may reach, in cubes that repeat, to be seen as one: no part beyond the cubes around is then the best.
pub(super) const WITHIN: f64 = 0.45;

/// A value and its gradient.
pub type Sample = (f64, DVec3);

/// Positions that are asked for at once.
pub const LANES: usize = 8;

/// Parts that make a solid, or whose union is the boundary of one.
pub trait Parts: Send + Sync {
    /// How many there are, at least one.
    fn count(&self) -> usize;

    /// The value of a part and its gradient, slope 1 at most: of a solid its signed distance, positive inside; of a piece
    /// of a boundary minus the distance to it.
    fn part(&self, index: usize, position: DVec3) -> Sample;

    /// The greatest value of some parts at each position, and which has it, the first where several have: those of
    /// [`Self::part`], bit for bit. Where none has a number it is −∞ of [`u32::MAX`].
    fn best(&self, among: &[u32], at: &[DVec3; LANES]) -> [(f64, u32); LANES] {
        at.map(|at| {
            let mut best = (f64::NEG_INFINITY, u32::MAX);
            for index in among {
                let value = self.part(*index as usize, at).0;
                best = if value > best.0 { (value, *index) } else { best };
            }
            best
        })
    }

    /// More parts of a region than this are more work at each point than a look for those of the point.
    fn most_listed(&self) -> usize {
        6
    }

    /// Whether a position is inside, where parts are pieces of a boundary.
    fn inside(&self, _position: DVec3) -> Option<bool> {
        None
    }

    /// A smooth function that is zero where the part is: across a crease each side has its own.
    fn carrier(&self, index: usize, position: DVec3) -> Sample {
        self.part(index, position)
    }

    /// A box, and the radius that a part reaches beyond it: its value is nowhere more than the radius minus the distance to
    /// the box. For parts that may be very many.
    fn core(&self, _index: usize) -> Option<(Aabb, f64)> {
        None
    }

    /// A box that holds the solid.
    fn bounding_box(&self) -> Option<Aabb>;

    /// What the value says about distance.
    fn slope(&self) -> Slope;

    /// Whether z plays no role.
    fn is_flat(&self) -> bool {
        false
    }

    /// The edge of the cubes in which all repeats. The parts then are those of a cube with one corner at the origin, and
    /// of all cubes around it.
    fn period(&self) -> Option<f64> {
        None
    }
}
