//! Closest points on a surface, wherever the asker stands.

use std::sync::atomic::AtomicBool;

use glam::DVec3;

use super::{Distance, Foot};

/// Answers closest points, in batches, from any thread.
pub trait ClosestPoint: Sync {
    /// The closest surface point to each position. Positions of one call lie near each other. `feet` has the
    /// length of `positions` and is overwritten; the answer to one position does not depend on the others, so
    /// that results are the same for any split into batches.
    fn feet(&self, positions: &[DVec3], feet: &mut [Foot]);
}

/// Every [`Distance`] answers for itself.
impl<T: Distance + ?Sized> ClosestPoint for T {
    fn feet(&self, positions: &[DVec3], feet: &mut [Foot]) {
        for (position, foot) in positions.iter().zip(feet) {
            *foot = self.foot(*position);
        }
    }
}

/// How a long computation is watched and stopped.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Set by another thread to stop the work.
    pub cancel: &'a AtomicBool,
    /// Called now and then with the part done, 0 to 1, from the thread that started the work.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

impl Watch<'_> {
    /// Whether the work is to stop.
    pub fn cancelled(&self) -> bool {
        self.cancel.load(std::sync::atomic::Ordering::Relaxed)
    }
}
