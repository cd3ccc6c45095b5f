//! Distances along the inside of a body, and values that go over into one another by them (CONFORMAL: `papers: Conformal
//! interpolation of material properties`).
//!
//! The interior distance of a point from a feature is the length of the shortest way that stays inside of the body
//! (eq. 1). It is found once for each feature on the nodes of a sparse lattice of the body's own ([`Body`]), by a wavefront
//! whose ways bend at nodes only and are straight in between ([`Feature`], Algorithm 1), and read anywhere from the bends of
//! the nodes around ([`Interior`], [`Conformal`]). All is in the body's space; signs are those of the crate: F positive
//! inside.
//!
//! Guaranteed: finite everywhere; exact in convex bodies; the same bits for any number of threads. Elsewhere a way
//! bends up to about a cell beside the corner that it should touch, so that it is too long by a fraction of a cell a bend.
//! Walls between parts of it are seen down to a twenty-fifth of a cell; [`Body::leak`] finds thinner ones.
//! Parts of the body that are thinner than a cell hold nodes too; two of them that pass through one cell are told apart
//! only where one is in sight.

#[cfg(test)]
mod accuracy_tests;
mod blend;
mod eikonal;
mod envelope;
mod feature;
mod interior;
mod leaks;
mod lookup;
mod nodes;

mod sight;
mod spread;
#[cfg(test)]
mod tests;
mod weights;

pub use blend::{Conformal, Member, Nearest};
pub use feature::{Feature, Method};
pub use interior::{Goal, Interior};
pub use leaks::Leak;
pub use nodes::Body;
pub use spread::Piece;
pub use weights::{Ease, Zones};

use glam::DVec3;

/// Why interior distances are not found.
#[derive(Clone, Debug, PartialEq)]
pub enum Error {
    /// Set to stop.
    Cancelled,
    /// The lattice would have about so many nodes, and may have so many.
    TooMany {
        /// About how many.
        nodes: usize,
        /// How many at most.
        most: usize,
    },
    /// No node is inside of the body.
    Empty,
    /// The distance to the feature is not a number at a position.
    NotANumber(DVec3),
    /// The speed there is no positive number.
    Speed {
        /// Units.
        at: DVec3,
        /// What it is.
        speed: f32,
    },
}
