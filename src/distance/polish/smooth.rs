//! Closest points on the zero set of one smooth function: Newton across the surface, projected steps along it.

use glam::Vec3;

use crate::field::{BATCH, Gradients, Points};

use super::{
    Request,
    kernel::{self, verdict},
    lanes::Lanes,
};

/// The most evaluations spent on a point. Smaller loses points near the centres of strong curvature, larger spends
/// time on points that no iteration brings to the surface. Ordinary points take two or three.
const EVALUATIONS: usize = 24;

/// A point this near to its foot (in units, across the surface) takes its last step unseen. The error left is its square times half the curvature: larger than 0.05 loses the thousandth of a voxel at strong curvature,
/// smaller costs an evaluation of every point.
pub(super) const LAST_STEP: f32 = 0.04;

/// A point this near to its foot along the surface (in units) takes its last step as if the surface were flat. The error
/// left is its square times half the curvature: 0.0003 units where the surface bends as a ball of 10.
pub(super) const LAST_SLIDE: f32 = 0.08;

/// A point takes its last step unseen where the steps before tell that it will miss by no more than this (in units), and
/// it makes up for that.
pub(super) const LAST_STRIDE: f32 = 0.004;

/// The least share of a step that is still tried; below it the point is taken where it stands.
const LEAST_SHARE: f32 = 1e-3;

/// The most that a step along the surface is lengthened. Smaller crawls near centres of curvature, larger overshoots.
pub(super) const GREATEST_SHARE: f32 = 6.0;

impl Lanes {
    /// Moves all lanes to their feet on the zero set of what `evaluate` evaluates.
    ///
    /// Along curved surfaces a full step over- or undershoots by 1 ± distance × curvature, so the share of the step
    /// along the surface is estimated from how the last step changed it, and a step that makes things worse is
    /// retaken shorter.
    pub fn solve(
        &mut self,
        request: &Request,
        gradients: &mut Gradients,
        mut evaluate: impl FnMut(&Points, &mut Gradients),
    ) {
        for _ in 0..EVALUATIONS {
            if self.points.len == 0 {
                return;
            }
            evaluate(&self.points, gradients);
            self.step(request, gradients);
        }
        for lane in 0..self.points.len {
            self.give_up(request, lane);
        }
    }

    /// Takes in the evaluation at all trial points, and chooses the next.
    pub fn step(&mut self, request: &Request, gradients: &Gradients) {
        kernel::judge(self, gradients, request.unit, request.reach);
        let mut keep = [true; BATCH];
        let mut finished = false;
        for lane in 0..self.points.len {
            match self.verdict[lane] {
                verdict::MOVES => continue,
                verdict::LANDS => {
                    let landing = vector(&self.landing, lane).to_array();
                    self.finish(lane, landing, self.height[lane]);
                    keep[lane] = false;
                }
                verdict::FAILS => keep[lane] = self.retreat(request, lane),
                _ => keep[lane] = false,
            }
            finished |= !keep[lane];
        }
        if finished {
            self.compact(&keep);
        }
    }

    /// The trial was worse than the base: a shorter step from there, or the base itself when nothing is gained.
    pub(super) fn retreat(&mut self, request: &Request, lane: usize) -> bool {
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

fn vector(arrays: &[[f32; BATCH]; 3], lane: usize) -> Vec3 {
    Vec3::new(arrays[0][lane], arrays[1][lane], arrays[2][lane])
}
