//! A field that tells all there is to tell, to see whether wrappers pass it on.

use glam::DVec3;

use super::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points};

/// The half-space z ≤ 0, which gives every hint and has two branches.
pub(crate) struct Hinted;

const HINTS: Hints = Hints { keeps_values: true, has_many_parts: true, vanishes: true, steepest: Some(1.0) };

/// Asserts that a wrapper gives every hint and branch of [`Hinted`] around the origin.
pub(crate) fn assert_passes_hints_on(evaluator: &mut dyn Evaluator) {
    for asked in [Hint::KeepsValues, Hint::HasManyParts, Hint::Vanishes, Hint::Steepest] {
        assert_eq!(evaluator.hints(asked), HINTS, "{asked:?}");
    }
    assert_eq!(evaluator.branches(), 2);
    let mut points = Points::new(DVec3::ZERO);
    points.push(glam::Vec3::ZERO);
    let mut out = Gradients::new();
    for branch in 0..2 {
        evaluator.branch(branch, &points, &mut out);
        assert_eq!(out.value[0], branch as f32);
    }
}

impl Field for Hinted {
    fn bounding_box(&self) -> Option<Aabb> {
        None
    }

    fn reference(&self, position: DVec3) -> f64 {
        -position.z
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(HintedEvaluator)
    }
}

struct HintedEvaluator;

impl Evaluator for HintedEvaluator {
    fn enter(&mut self, _: &Aabb) {}

    fn bounds(&mut self) -> Interval {
        Interval::ALL
    }

    fn hints(&mut self, _: Hint) -> Hints {
        HINTS
    }

    fn leave(&mut self) {}

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        (0..points.len).for_each(|i| out[i] = Hinted.reference(points.position(i)) as f32);
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        self.values(points, &mut out.value);
        (out.dx, out.dy, out.dz) = ([0.0; BATCH], [0.0; BATCH], [-1.0; BATCH]);
    }

    fn branches(&self) -> usize {
        2
    }

    fn branch(&mut self, branch: usize, points: &Points, out: &mut Gradients) {
        self.gradients(points, out);
        out.value[..points.len].iter_mut().for_each(|value| *value += branch as f32);
    }
}
