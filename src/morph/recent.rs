//! What was worked out for the scene times asked for last.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// How many scene times are kept: those of two frames in flight, of the frames before them, and of the instants beside
/// them that velocities are taken from.
const KEPT: usize = 8;

/// Results by scene time, of a pure function of it.
pub(super) struct Recent<T>(Mutex<VecDeque<(f64, Arc<T>)>>);

impl<T> Recent<T> {
    pub(super) fn new() -> Self {
        Self(Mutex::new(VecDeque::with_capacity(KEPT)))
    }

    /// The result at a time; made anew where it is not kept. It is made outside of the lock: threads that want the same
    /// at once may both make it, but none waits for another's parallel loops.
    pub(super) fn at(&self, time: f64, make: impl FnOnce() -> T) -> Arc<T> {
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = lock().iter().find(|(kept, _)| *kept == time).map(|(_, result)| Arc::clone(result));
        known.unwrap_or_else(|| {
            let result = Arc::new(make());
            let mut kept = lock();
            kept.truncate(KEPT - 1);
            kept.push_front((time, Arc::clone(&result)));
            result
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_are_kept() {
        let recent = Recent::new();
        let times = |count: usize| (0..count).map(|time| time as f64);
        times(KEPT + 1).for_each(|time| assert_eq!(*recent.at(time, || time + 0.5), time + 0.5));
        times(KEPT + 1).skip(1).for_each(|time| assert_eq!(*recent.at(time, || f64::NAN), time + 0.5));
        assert_eq!(*recent.at(0.0, || 7.0), 7.0);
    }
}
