//! A scalar as a field, so that it can be a term of one.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::{Sampler, Scalar};
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points};

/// Samples are `f32`, and so are the sums they come from: how far beyond its bounds one may be, as a share of them.
const SLACK: f64 = 4.0 * f32::EPSILON as f64;

/// A scalar's values as those of a field, held to a greatest value. Its gradient is the scalar's own, or else by central
/// differences.
pub struct ScalarField {
    /// The scalar.
    pub scalar: Arc<Scalar>,
    /// Greater values are this one.
    pub most: f64,
    /// Half of what the values are taken apart for the gradient, world units. Greater rounds the scalar's own detail;
    /// smaller lets rounding show.
    pub step: f64,
}

impl Field for ScalarField {
    fn bounding_box(&self) -> Option<Aabb> {
        None
    }

    fn reference(&self, position: DVec3) -> f64 {
        let (mut points, mut out) = (Points::new(position), [[0.0]; BATCH]);
        points.push(Vec3::ZERO);
        self.scalar.sampler().sample(&points, &mut out);
        held(f64::from(out[0][0]), self.most)
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(ScalarEvaluator {
            field: self,
            sampler: self.scalar.sampler(),
            entered: Vec::new(),
            there: Points::new(DVec3::ZERO),
            sides: [[[0.0]; BATCH]; 2],
        })
    }
}

/// NaN stays NaN, so that it is found and told.
fn held<T: PartialOrd>(value: T, most: T) -> T {
    if value > most { most } else { value }
}

struct ScalarEvaluator<'a> {
    field: &'a ScalarField,
    sampler: Box<dyn Sampler<1> + 'a>,
    /// Each region entered, and the bounds over it once they were asked for.
    entered: Vec<(Aabb, Option<Interval>)>,
    there: Points,
    sides: [[[f32; 1]; BATCH]; 2],
}

impl ScalarEvaluator<'_> {
    /// The samples at the points, moved by a way.
    fn sample(&mut self, points: &Points, way: DVec3, side: usize) {
        self.there.clone_from(points);
        self.there.origin += way;
        self.sampler.sample(&self.there, &mut self.sides[side]);
        let most = self.field.most as f32;
        self.sides[side].as_flattened_mut()[..points.len].iter_mut().for_each(|value| *value = held(*value, most));
    }
}

impl Evaluator for ScalarEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.entered.push((*region, None));
        // One step further than the points, for the differences.
        self.sampler.enter(&region.grown(self.field.step));
    }

    fn bounds(&mut self) -> Interval {
        let Some((region, bounds)) = self.entered.last_mut() else { return Interval::ALL };
        *bounds.get_or_insert_with(|| {
            let [Interval { lo, hi }] = self.sampler.bounds(region);
            let most = self.field.most;
            Interval::new((lo - lo.abs() * SLACK).min(most), (hi + hi.abs() * SLACK).min(most))
        })
    }

    fn hints(&mut self, _: Hint) -> Hints {
        Hints { keeps_values: true, ..Hints::NONE }
    }

    fn leave(&mut self) {
        self.entered.pop();
        self.sampler.leave();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        self.sample(points, DVec3::ZERO, 0);
        out[..points.len].copy_from_slice(&self.sides[0].as_flattened()[..points.len]);
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        if self.sampler.gradients(points, std::array::from_mut(out)) {
            let most = self.field.most as f32;
            for i in 0..points.len {
                if out.value[i] > most {
                    (out.value[i], out.dx[i], out.dy[i], out.dz[i]) = (most, 0.0, 0.0, 0.0);
                }
            }
            return;
        }
        self.values(points, &mut out.value);
        let step = self.field.step;
        let scale = (0.5 / step) as f32;
        for (axis, slopes) in [&mut out.dx, &mut out.dy, &mut out.dz].into_iter().enumerate() {
            self.sample(points, -DVec3::AXES[axis] * step, 0);
            self.sample(points, DVec3::AXES[axis] * step, 1);
            let [before, after] = &self.sides;
            for ((slope, before), after) in slopes.iter_mut().zip(before).zip(after).take(points.len) {
                *slope = (after[0] - before[0]) * scale;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attribute::{Constant, FieldValue};
    use crate::field::{Expression, Formula, Graph, Names};

    fn by_formula(text: &str, most: f64) -> ScalarField {
        let mut graph = Graph::new();
        let names = Names::space(&mut graph);
        let node = Formula::parse(text).compile(&mut graph, &names).expect("a formula");
        let field = Expression::new(&graph, node).keeping_values();
        ScalarField { scalar: Arc::new(FieldValue(Arc::new(field))), most, step: 1e-4 }
    }

    fn points() -> Points {
        let mut points = Points::new(DVec3::new(0.4, -0.3, 0.2));
        (0..64).for_each(|i| points.push(Vec3::new(i as f32, (i * 7 % 64) as f32, (i * 11 % 64) as f32) * 0.003));
        points
    }

    #[test]
    fn gradients_are_those_of_the_scalar() {
        // By the formula's own gradient; and by differences, where it may jump.
        for (jump, tolerance) in [("", 1e-6), (" + floor(x)", 5e-4)] {
            let field = by_formula(&format!("0.1*sin(5*x)*cos(4*y) + 0.2*z^2{jump}"), f64::INFINITY);
            let (points, mut out) = (points(), Gradients::new());
            field.evaluator().gradients(&points, &mut out);
            for i in 0..points.len {
                let DVec3 { x, y, z } = points.position(i);
                let (five, four) = ((5.0 * x).sin_cos(), (4.0 * y).sin_cos());
                let exact = DVec3::new(0.5 * five.1 * four.1, -0.4 * five.0 * four.0, 0.4 * z);
                assert!((out.gradient(i).as_dvec3() - exact).length() < tolerance, "{} {exact}", out.gradient(i));
                let value = 0.1 * five.0 * four.1 + 0.2 * z * z;
                assert!(
                    (f64::from(out.value[i]) - value).abs() < 1e-7
                        && (field.reference(points.position(i)) - value).abs() < 1e-7
                );
            }
        }
    }

    #[test]
    fn across_a_jump_gradients_are_steep() {
        let field = by_formula("0.1*floor(4*x)", 9.0);
        let mut points = Points::new(DVec3::new(0.5, 0.3, 0.2));
        [-1e-3, -5e-5, 5e-5, 1e-3].into_iter().for_each(|x| points.push(Vec3::new(x, 0.0, 0.0)));
        let mut out = Gradients::new();
        field.evaluator().gradients(&points, &mut out);
        // 0.1 over twice the step.
        for (found, exact) in out.dx.into_iter().zip([0.0, 500.0, 500.0, 0.0]) {
            assert!((found - exact).abs() < 0.1, "{found}");
        }
    }

    #[test]
    fn values_lie_in_the_bounds_and_are_held() {
        let points = points();
        let around = Aabb::new(DVec3::new(0.4, -0.3, 0.2), DVec3::new(0.6, -0.1, 0.4));
        for (field, hi) in [
            (by_formula("x - y*z", 0.5), 0.5),
            (by_formula("x - y*z", 9.0), 0.72),
            (ScalarField { scalar: Arc::new(Constant::new([0.25])), most: 9.0, step: 1e-4 }, 0.25),
        ] {
            let mut evaluator = field.evaluator();
            evaluator.enter(&around);
            let (bounds, mut out) = (evaluator.bounds(), [0.0; BATCH]);
            assert!((bounds.hi - hi).abs() < 1e-6, "{bounds:?}");
            evaluator.values(&points, &mut out);
            evaluator.leave();
            assert!(out[..points.len].iter().all(|value| bounds.contains(f64::from(*value))));
        }
        // NaN is no value to hold.
        let mut out = [0.0; BATCH];
        by_formula("log(x - 9)", 0.5).evaluator().values(&points, &mut out);
        assert!(out[0].is_nan());
    }
}
