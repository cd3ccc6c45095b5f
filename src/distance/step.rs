//! The smooth step in the place of a distance's sign (HFRep, eq. 21 and 23): S(x) = 2/(1 + exp(−2x/s)) − 1, which is tanh(x/s).
//!
//! For x the paper has F, whatever its slope. Here it is the distance, which is F over its slope to first order, so that s is a
//! length. The result |d|·tanh(d/s) is C¹ across the surface because its slope there is 0: near it it is d·|d|/s. It is short of
//! the distance by up to 0.278 s, at 0.64 s, and its slope goes up to 1.20, at 1.2 s.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points};
use crate::grid::{Band, mask};

/// A signed distance with the smooth step of a length s for its sign.
pub fn smooth_step(distance: f64, s: f64) -> f64 {
    distance.abs() * libm::tanh(distance / s)
}

/// The same of a band, s in voxels. What is inside stays so.
pub fn soften(band: &mut Band, s: f64) {
    let s = s * band.lattice.voxel_size.get();
    let Band { distances, active, .. } = band;
    distances.par_iter_mut().zip(active).for_each(|(distances, active)| {
        for place in mask::places(active) {
            let own = distances[place];
            let magnitude = smooth_step(f64::from(own), s).abs() as f32;
            // 0 has no side.
            distances[place] = magnitude.max(f32::MIN_POSITIVE).copysign(own);
        }
    });
}

/// A distance with the smooth step for its sign.
pub struct Stepped {
    /// The distance.
    pub distance: Arc<dyn Field>,
    /// s, world units.
    pub s: f64,
}

impl Field for Stepped {
    fn bounding_box(&self) -> Option<Aabb> {
        self.distance.bounding_box()
    }

    fn jumps(&self) -> bool {
        self.distance.jumps()
    }

    fn reference(&self, position: DVec3) -> f64 {
        smooth_step(self.distance.reference(position), self.s)
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(SteppedEvaluator { distance: self.distance.evaluator(), s: self.s })
    }
}

struct SteppedEvaluator<'a> {
    distance: Box<dyn Evaluator + 'a>,
    s: f64,
}

impl SteppedEvaluator<'_> {
    fn value(&self, distance: f32) -> f32 {
        smooth_step(f64::from(distance), self.s) as f32
    }
}

impl Evaluator for SteppedEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.distance.enter(region);
    }

    fn bounds(&mut self) -> Interval {
        // It rises with the distance; values are rounded to 32 bits.
        let Interval { lo, hi } = self.distance.bounds();
        let end = |distance: f64, out: f64| {
            let value = if distance.is_finite() { smooth_step(distance, self.s) } else { distance };
            value + out * 1e-6 * value.abs()
        };
        Interval::new(end(lo, -1.0), end(hi, 1.0))
    }

    fn hints(&mut self, asked: Hint) -> Hints {
        Hints { steepest: None, ..self.distance.hints(asked) }
    }

    fn leave(&mut self) {
        self.distance.leave();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        self.distance.values(points, out);
        for out in out.iter_mut().take(points.len) {
            *out = self.value(*out);
        }
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        self.distance.gradients(points, out);
        for i in 0..points.len {
            let x = f64::from(out.value[i]) / self.s;
            let (rise, size) = (libm::tanh(x), x.abs());
            let slope = (rise.abs() + size * (1.0 - rise * rise)) as f32;
            out.value[i] = self.value(out.value[i]);
            for part in [&mut out.dx[i], &mut out.dy[i], &mut out.dz[i]] {
                *part *= slope;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Expression, Graph};
    use crate::grid::testing::sphere;

    /// The numbers of the module's first lines, and no slope on the surface.
    #[test]
    fn it_is_as_wrong_as_is_said() {
        let (mut short, mut steepest) = ((0.0_f64, 0.0), (0.0_f64, 0.0));
        for i in 0..4000 {
            let x = f64::from(i) * 1e-3;
            let slope = (smooth_step(x + 1e-6, 1.0) - smooth_step(x - 1e-6, 1.0)) / 2e-6;
            short = if x - smooth_step(x, 1.0) > short.0 { (x - smooth_step(x, 1.0), x) } else { short };
            steepest = if slope > steepest.0 { (slope, x) } else { steepest };
            assert_eq!(smooth_step(-x, 1.0), -smooth_step(x, 1.0));
        }
        assert!((short.0 - 0.278).abs() < 1e-3 && (short.1 - 0.64).abs() < 0.01, "{short:?}");
        assert!((steepest.0 - 1.20).abs() < 1e-2 && (steepest.1 - 1.2).abs() < 0.02, "{steepest:?}");
        assert!(smooth_step(1e-4, 1.0) < 1.1e-8);
        // A step that is steep is the sign.
        assert_eq!(smooth_step(0.5, 1e-5), 0.5);
    }

    #[test]
    fn voxels_keep_their_sides() {
        let before = sphere(DVec3::ZERO, 1.0, 0.1);
        let mut after = before.clone();
        soften(&mut after, 1.0);
        for (block, active) in before.active.iter().enumerate() {
            for place in mask::places(active) {
                let (was, is) = (before.distances[block][place], after.distances[block][place]);
                assert!(
                    is.abs() <= was.abs().max(f32::MIN_POSITIVE)
                        && is != 0.0
                        && is.is_sign_negative() == was.is_sign_negative()
                );
            }
        }
        assert!(before.distances != after.distances);
    }

    /// Values, gradients and bounds agree, and it vanishes where the distance does.
    #[test]
    fn a_field_takes_the_step_everywhere() {
        let mut graph = Graph::new();
        let node = graph.affine(DVec3::NEG_X, 0.0);
        let field = Stepped { distance: Arc::new(Expression::new(&graph, node)), s: 0.3 };
        let mut evaluator = field.evaluator();
        let mut points = Points::new(DVec3::ZERO);
        (0..BATCH).for_each(|i| points.push(DVec3::new(i as f64 / 256.0 - 1.0, 0.1, 0.2).as_vec3()));
        let (mut values, mut gradients) = ([0.0; BATCH], Gradients::new());
        evaluator.enter(&Aabb::new(DVec3::NEG_ONE, DVec3::ONE));
        let bounds = evaluator.bounds();
        evaluator.values(&points, &mut values);
        evaluator.gradients(&points, &mut gradients);
        evaluator.leave();
        for (i, value) in values.iter().enumerate() {
            let x = points.position(i).x;
            let exact = |x: f64| -x.abs() * libm::tanh(x / 0.3);
            assert!((f64::from(*value) - exact(x)).abs() < 1e-6 && *value == gradients.value[i]);
            assert!(bounds.contains(f64::from(*value)));
            let slope = (exact(x + 1e-5) - exact(x - 1e-5)) / 2e-5;
            assert!((f64::from(gradients.dx[i]) - slope).abs() < 1e-4, "{x}");
        }
    }
}
