//! What goes wrong after a scene was checked: while meshes are read, objects measured, frames made.

use std::fmt;

use super::diagnostic::{Diagnostic, Diagnostics};
use super::model::Model;
use super::number::BadNumber;
use super::source::Span;

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

/// A problem with its place, before the scene's texts are at hand.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Problem(pub Box<Diagnostic>);

impl Problem {
    /// About a piece of the scene.
    pub fn new(span: Span, message: impl Into<String>) -> Self {
        Self(Box::new(Diagnostic::error(span, message)))
    }

    /// With what to do next.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.0.help = help.into();
        self
    }
}

impl From<BadNumber> for Problem {
    fn from(bad: BadNumber) -> Self {
        Self::new(bad.span, bad.message)
    }
}

impl Model {
    /// A problem as an error, with this scene's text.
    pub(super) fn error(&self, problem: Problem) -> Error {
        Error::Scene(Diagnostics::new(vec![*problem.0], self.sources.clone()))
    }
}
