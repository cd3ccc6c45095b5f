//! Why making ready for frames stopped.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::distance::octree::BuildError;
use crate::shot::error::Error;
use crate::text::problem::Problem;

/// Why preparing stopped.
pub(crate) enum Stop {
    Cancelled,
    Memory { needed: u64, limit: u64, voxels: f64 },
    Problem(Problem),
}

impl Stop {
    /// Why distances were not measured; `problem` puts the words of one that was not the caller's wish in their place.
    pub fn of_measuring(error: &BuildError, problem: impl FnOnce(String) -> Problem) -> Self {
        match error {
            BuildError::Cancelled => Self::Cancelled,
            error => Self::Problem(problem(error.to_string())),
        }
    }
}

impl From<Problem> for Stop {
    fn from(problem: Problem) -> Self {
        Self::Problem(problem)
    }
}

pub(crate) fn stop_if(cancel: &AtomicBool) -> Result<(), Stop> {
    if cancel.load(Ordering::Relaxed) { Err(Stop::Cancelled) } else { Ok(()) }
}

/// What fails once it was told to stop has stopped, whatever it says.
pub(crate) fn unless_cancelled<T>(cancel: &AtomicBool, result: Result<T, Error>) -> Result<T, Error> {
    result.map_err(|error| if cancel.load(Ordering::Relaxed) { Error::Cancelled } else { error })
}
