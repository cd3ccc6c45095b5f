//! What a frame is asked for, and why it may not be had.

use std::fmt;
use std::sync::Arc;

use super::Bytes;
use crate::attribute::{Colour, LinearRgb, Scalar};
use crate::distance::band;
use crate::distance::octree::BuildError;
use crate::morph::Movement;

/// The attributes that a frame's grids are made from, each with the name of its grid.
#[derive(Clone, Copy)]
pub struct Attributes<'a> {
    /// The colour, if there is one.
    pub colour: Option<(&'a str, &'a Colour)>,
    /// The scalars.
    pub scalars: &'a [(String, Arc<Scalar>)],
    /// How the surface moves, where velocities are asked for.
    pub movement: Option<&'a Movement>,
    /// What of the inside is asked for.
    pub interior: Option<Interior>,
}

/// What of the inside is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Interior {
    /// Whether it has a density.
    pub density: bool,
    /// The most memory that one of its grids may take.
    pub limit: Bytes,
}

/// Why a frame could not be computed.
#[derive(Clone, Debug, PartialEq)]
pub enum ComputeError {
    /// The distances.
    Distance(band::Error),
    /// What the method by which the scene measures them has to say.
    Method(BuildError),
    /// A colour is negative, infinite or not a number at a world position.
    Colour {
        /// World units.
        position: [f64; 3],
        /// The colour.
        value: LinearRgb,
    },
    /// The inside takes more memory than is allowed: about so much, in bytes, of so many voxels.
    Memory {
        /// Bytes.
        needed: u64,
        /// Voxels inside.
        voxels: u64,
    },
    /// A density is negative at a world position.
    Density {
        /// World units.
        position: [f64; 3],
        /// The number.
        value: f32,
    },
    /// A scalar is infinite or not a number at a world position.
    Scalar {
        /// The name of its grid.
        name: String,
        /// World units.
        position: [f64; 3],
        /// The number.
        value: f32,
    },
}

impl fmt::Display for ComputeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Distance(error) => error.fmt(f),
            Self::Method(error) => error.fmt(f),
            Self::Colour { position: [x, y, z], value: [r, g, b] } => write!(
                f,
                "the colour at ({x:.6}, {y:.6}, {z:.6}) is ({r}, {g}, {b}): a channel is negative, infinite or not a number"
            ),
            Self::Memory { needed, voxels } => {
                write!(f, "{voxels} voxels inside would take about {} of memory", Bytes(*needed))
            }
            Self::Density { position: [x, y, z], value } => {
                write!(f, "`density` at ({x:.6}, {y:.6}, {z:.6}) is {value}: it cannot be negative")
            }
            Self::Scalar { name, position: [x, y, z], value } => {
                write!(f, "`{name}` at ({x:.6}, {y:.6}, {z:.6}) is {value}: it must be a finite number")
            }
        }
    }
}

impl std::error::Error for ComputeError {}

impl ComputeError {
    /// What a method can fail by whose band was measured before.
    pub(super) fn of_method(error: BuildError) -> Self {
        match error {
            BuildError::Surface(error) => Self::Distance(error),
            BuildError::NotFinite { position } => Self::Distance(band::Error::NotANumber { position }),
            BuildError::Cancelled => Self::Distance(band::Error::Cancelled),
            error => Self::Method(error),
        }
    }
}
