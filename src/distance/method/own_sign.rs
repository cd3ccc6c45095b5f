//! A distance whose magnitude is restored from nodes and whose sign is F's own (HFRep, eq. 14 with the exact sign).

use std::sync::Arc;

use glam::DVec3;

use crate::distance::{Distance, Foot};
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points, Slope};

/// The restored distance v on its own side of F, 0 where v is on the other: max(v, 0) where F ≥ 0, min(v, 0) elsewhere.
///
/// **Guaranteed:** inside where F is, bit for bit. **Not guaranteed:** on F's surface it jumps by as much as v is wrong
/// there, so no slope is declared.
pub struct OwnSign {
    /// v.
    pub magnitude: Arc<dyn Field>,
    /// F.
    pub field: Arc<dyn Field>,
}

/// A value that is on its own side.
fn on_side(value: f32, inside: bool) -> f32 {
    match (inside, value) {
        (true, value) if value < 0.0 => 0.0,
        // −0 is not inside for who asks for a sign bit, nor is it below 0 for who compares.
        (false, value) if value >= 0.0 => -f32::MIN_POSITIVE,
        _ => value,
    }
}

impl Field for OwnSign {
    fn bounding_box(&self) -> Option<Aabb> {
        self.field.bounding_box().or_else(|| self.magnitude.bounding_box())
    }

    fn slope(&self) -> Slope {
        Slope::Unknown
    }

    fn jumps(&self) -> bool {
        true
    }

    fn reference(&self, position: DVec3) -> f64 {
        let value = self.magnitude.reference(position);
        if self.field.reference(position) >= 0.0 { value.max(0.0) } else { value.min(f64::from(-f32::MIN_POSITIVE)) }
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(OwnSignEvaluator {
            magnitude: self.magnitude.evaluator(),
            field: self.field.evaluator(),
            signs: [0.0; BATCH],
        })
    }
}

impl Distance for OwnSign {
    /// Nodes keep no points.
    fn closest_points(&self, _: &[DVec3], _: &mut [Foot]) -> bool {
        false
    }
}

struct OwnSignEvaluator<'a> {
    magnitude: Box<dyn Evaluator + 'a>,
    field: Box<dyn Evaluator + 'a>,
    signs: [f32; BATCH],
}

impl OwnSignEvaluator<'_> {
    fn sign(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        self.field.values(points, &mut self.signs);
        for (value, sign) in out.iter_mut().zip(&self.signs).take(points.len) {
            // Where F is no number there is no side.
            *value = if sign.is_nan() { f32::NAN } else { on_side(*value, *sign >= 0.0) };
        }
    }
}

impl Evaluator for OwnSignEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.magnitude.enter(region);
        // Pruning keeps F's sign, and no more of it is used.
        self.field.enter(region);
    }

    fn bounds(&mut self) -> Interval {
        let (magnitude, side) = (self.magnitude.bounds(), self.field.bounds());
        if side.lo >= 0.0 {
            return Interval::new(magnitude.lo.max(0.0), magnitude.hi.max(0.0));
        }
        let tiny = f64::from(-f32::MIN_POSITIVE);
        if side.hi < 0.0 {
            return Interval::new(magnitude.lo.min(tiny), magnitude.hi.min(tiny));
        }
        Interval::new(magnitude.lo.min(tiny), magnitude.hi.max(0.0))
    }

    fn hints(&mut self, asked: Hint) -> Hints {
        Hints { keeps_values: true, steepest: None, ..self.field.hints(asked) }
    }

    fn leave(&mut self) {
        self.magnitude.leave();
        self.field.leave();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        self.magnitude.values(points, out);
        self.sign(points, out);
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        self.magnitude.gradients(points, out);
        self.sign(points, &mut out.value);
    }
}
