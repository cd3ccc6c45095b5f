//! Closest points on the zero set of one smooth function: Newton across the surface, projected steps along it.

use glam::Vec3;

use crate::field::{BATCH, Gradients, Points};

use super::{Request, lanes::Lanes};

/// The most evaluations spent on a point. Smaller loses points near the centres of strong curvature, larger spends
/// time on points that no iteration brings to the surface. Ordinary points take two or three.
const EVALUATIONS: usize = 24;

/// A point this near to its foot (in units, across and along the surface) takes its last step unseen. The error left
/// is its square times half the curvature: larger than 0.05 loses the thousandth of a voxel at strong curvature,
/// smaller costs an evaluation of every point.
pub(super) const LAST_STEP: f32 = 0.04;

/// The least share of a step that is still tried; below it the point is taken where it stands.
const LEAST_SHARE: f32 = 1e-3;

/// The most that a step along the surface is lengthened. Smaller crawls near centres of curvature, larger overshoots.
const GREATEST_SHARE: f32 = 6.0;

impl Lanes {
    /// Moves all lanes to their feet on the zero set of what `evaluate` evaluates.
    ///
    /// With n the unit gradient and e = F/|∇F|, the zero set is near q the plane that p + s·n meets at
    /// s = −(e + (p − q)·n): a step goes there. Along curved surfaces that over- or undershoots by 1 ± distance ×
    /// curvature, so the share of the step along the surface is estimated from how the last step changed it, and a
    /// step that makes things worse is retaken shorter.
    pub fn solve(
        &mut self,
        request: &Request,
        gradients: &mut Gradients,
        mut evaluate: impl FnMut(&Points, &mut Gradients),
    ) {
        let mut keep = [true; BATCH];
        for _ in 0..EVALUATIONS {
            if self.points.len == 0 {
                return;
            }
            evaluate(&self.points, gradients);
            let mut finished = false;
            for lane in 0..self.points.len {
                keep[lane] = self.advance(request, gradients, lane);
                finished |= !keep[lane];
            }
            if finished {
                self.compact(&keep);
            }
        }
        for lane in 0..self.points.len {
            self.give_up(request, lane);
        }
    }

    /// Takes in the evaluation at a lane's trial point; false when the lane is done.
    fn advance(&mut self, request: &Request, gradients: &Gradients, lane: usize) -> bool {
        let q = self.points.offset(lane);
        let p = vector(&self.p, lane);
        let gradient = gradients.gradient(lane);
        let slope = gradient.length();
        let residual = gradients.value[lane] / slope;
        let towards = p - q;
        let normal = gradient / slope;
        // The distance to where the next step across the surface lands, and some doubt about landing there.
        let merit = (towards + normal * residual).length() + 0.3 * residual.abs();
        let near = LAST_STEP * request.unit;
        let approaches = self.residual[lane] > near && residual.abs() < 0.8 * self.residual[lane];
        let improves = merit <= self.merit[lane] * 1.0001 && !self.strayed(lane, residual.abs());
        if !merit.is_finite() || !(approaches || improves) {
            return self.retreat(request, lane);
        }
        let height = towards.dot(normal);
        let tangent = towards - normal * height;
        if residual.abs() <= near && tangent.length_squared() <= near * near {
            let distance = residual + height;
            self.finish(lane, (p - normal * distance).to_array(), distance.abs());
            return false;
        }
        if self.merit[lane] < f32::INFINITY {
            let share = self.along[lane];
            self.along[lane] = next_share(share, vector(&self.tangent_step, lane), tangent);
        }
        self.across[lane] = 1.0;
        self.merit[lane] = merit;
        self.residual[lane] = residual.abs();
        set(&mut self.base, lane, q);
        set(&mut self.normal_step, lane, normal * -residual);
        set(&mut self.tangent_step, lane, tangent);
        self.try_step(lane);
        true
    }

    /// Whether a step has left the surface so far (the more so the longer it was) that its merit cannot be trusted.
    fn strayed(&self, lane: usize, residual: f32) -> bool {
        let length = self.along[lane] * vector(&self.tangent_step, lane).length();
        self.merit[lane] < f32::INFINITY && residual > 0.8 * self.residual[lane] + 0.3 * length
    }

    /// The trial was worse than the base: a shorter step from there, or the base itself when nothing is gained.
    fn retreat(&mut self, request: &Request, lane: usize) -> bool {
        if self.merit[lane] == f32::INFINITY {
            return false;
        }
        self.along[lane] *= 0.3;
        self.across[lane] *= 0.5;
        if self.along[lane] < LEAST_SHARE || self.across[lane] < LEAST_SHARE {
            self.give_up(request, lane);
            return false;
        }
        self.try_step(lane);
        true
    }

    fn try_step(&mut self, lane: usize) {
        let step =
            vector(&self.normal_step, lane) * self.across[lane] + vector(&self.tangent_step, lane) * self.along[lane];
        let [least, greatest] = self.bounds.map(Vec3::from_array);
        let trial = (vector(&self.base, lane) + step).clamp(least, greatest);
        (self.points.x[lane], self.points.y[lane], self.points.z[lane]) = trial.into();
    }

    /// Takes the last accepted point, where it is on the surface, though a nearer one may exist.
    fn give_up(&mut self, request: &Request, lane: usize) {
        if self.residual[lane] <= LAST_STEP * request.unit {
            let foot = vector(&self.base, lane) + vector(&self.normal_step, lane);
            self.finish(lane, foot.to_array(), (vector(&self.p, lane) - foot).length());
        }
    }
}

/// The share of the tangential step that would have brought it to zero, were its change linear in the step (the
/// secant of Barzilai and Borwein); the greatest where the steps grow, as near the far side of a ball.
fn next_share(share: f32, before: Vec3, after: Vec3) -> f32 {
    let change = before - after;
    let (gain, size) = (before.dot(change), change.length_squared());
    if before == Vec3::ZERO || size == 0.0 {
        1.0
    } else if gain <= 0.0 {
        GREATEST_SHARE
    } else {
        (share * gain / size).clamp(0.1, GREATEST_SHARE)
    }
}

fn vector(arrays: &[[f32; BATCH]; 3], lane: usize) -> Vec3 {
    Vec3::new(arrays[0][lane], arrays[1][lane], arrays[2][lane])
}

fn set(arrays: &mut [[f32; BATCH]; 3], lane: usize, value: Vec3) {
    (arrays[0][lane], arrays[1][lane], arrays[2][lane]) = value.into();
}
