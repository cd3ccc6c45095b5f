//! The distances of both objects of a morph, on one thread.

use crate::field::{Aabb, Evaluator, Interval};

/// Two evaluators that enter regions together.
pub(super) struct Both<'a> {
    pub first: Box<dyn Evaluator + 'a>,
    pub second: Box<dyn Evaluator + 'a>,
    /// One over D.
    per_unit: f64,
}

impl<'a> Both<'a> {
    pub(super) fn new(first: Box<dyn Evaluator + 'a>, second: Box<dyn Evaluator + 'a>, unit: f64) -> Self {
        Self { first, second, per_unit: 1.0 / unit }
    }

    pub(super) fn enter(&mut self, region: &Aabb) {
        self.first.enter(region);
        self.second.enter(region);
    }

    pub(super) fn leave(&mut self) {
        self.first.leave();
        self.second.leave();
    }

    /// Bounds of both distances over the region entered, in units of D.
    pub(super) fn bounds(&mut self) -> [Interval; 2] {
        [&mut self.first, &mut self.second].map(|object| scaled(object.bounds(), self.per_unit))
    }
}

/// Bounds of values times a length.
pub(super) fn scaled(bounds: Interval, by: f64) -> Interval {
    Interval::new(bounds.lo * by, bounds.hi * by)
}
