//! A moment of the shot, as formulas know it.

use std::sync::Arc;

/// A point in time, with what a formula knows of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// 0 at the shot's first frame, 1 at its last.
    pub t: f64,
    /// The frame; between two frames a fraction.
    pub frame: f64,
    /// Seconds since the first frame.
    pub time: f64,
    /// The parameters' values, in the order of the names that formulas were read with.
    pub parameters: Arc<[f64]>,
}

impl Moment {
    /// Some moment with a value for each parameter: to find out whether formulas can be read.
    pub(crate) fn any(names: &[String]) -> Self {
        Self { t: 0.0, frame: 1.0, time: 0.0, parameters: names.iter().map(|_| 1.0).collect() }
    }
}
