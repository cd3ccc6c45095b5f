//! Distances along the inside of a body, and values that go over into one another by them (CONFORMAL: `papers: Conformal
//! interpolation of material properties`).
//!
//! The interior distance of a point from a feature is the length of the shortest way that stays inside of the body
//! (eq. 1). It is found once for each feature on the nodes of a sparse lattice of the body's own ([`Body`]), by a wavefront
//! whose ways bend at nodes only and are straight in between ([`Feature`], Algorithm 1), and read anywhere from the bends of
//! the nodes around ([`Interior`], [`Conformal`]). All is in the body's space; signs are those of the crate: F positive
//! inside.
//!
//! Guaranteed: finite everywhere; exact in convex bodies; the same bits for any number of threads. Elsewhere bends are
//! drawn taut against the corners that they go around, to a few hundredths of a cell each.
//! Walls between parts of it are seen down to a twenty-fifth of a cell; [`Body::leak`] finds thinner ones.
//! Parts of the body that are thinner than a cell hold nodes too; two of them that pass through one cell are told apart
//! only where one is in sight.

pub mod accuracy;
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
mod outside;
mod sight;
mod spread;
mod taut;
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

use std::fmt;

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

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cancelled => f.write_str("stopped"),
            Self::TooMany { nodes, most } => {
                write!(f, "the lattice takes about {nodes} nodes, and {most} are the most")
            }
            Self::Empty => f.write_str("nothing is inside of the body"),
            Self::NotANumber(at) => write!(f, "the distance to the feature is not a number at {at}"),
            Self::Speed { at, speed } => write!(f, "the speed at {at} is {speed}: it must be finite and positive"),
        }
    }
}

impl std::error::Error for Error {}
