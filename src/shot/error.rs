//! What goes wrong after a scene was checked: while meshes are read, objects measured, frames made.

use std::fmt;

use crate::node::model::Model;
use crate::text::diagnostic::Diagnostics;
use crate::text::problem::Problem;

/// Why a scene gives no frames.
#[derive(Clone, Debug)]
pub enum Error {
    /// Something about the scene, with its place.
    Scene(Diagnostics),
    /// Frames would take more memory than allowed.
    Memory {
        /// About what is needed, in bytes.
        needed: u64,
        /// What is allowed, in bytes.
        limit: u64,
        /// About how many active voxels a frame has.
        voxels: f64,
    },
    /// The caller's wish.
    Cancelled,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scene(diagnostics) => diagnostics.fmt(f),
            Self::Memory { needed, limit, voxels } => write!(
                f,
                "about {voxels:.2e} voxels would take about {needed} bytes of memory, and the limit is {limit}"
            ),
            Self::Cancelled => f.write_str("cancelled"),
        }
    }
}

impl std::error::Error for Error {}

impl Model {
    /// A problem as an error, with this scene's text.
    pub(crate) fn error(&self, problem: Problem) -> Error {
        Error::Scene(Diagnostics::new(vec![*problem.0], self.sources.clone()))
    }
}
