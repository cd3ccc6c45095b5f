//! One Newton step of many lanes at once, compiled for several vector widths. Plain arithmetic without branches; the
//! widths agree bit for bit.

use multiversion::multiversion;

use crate::field::{BATCH, Gradients};

use super::{
    lanes::Lanes,
    smooth::{GREATEST_SHARE, LAST_STEP},
};

/// Lanes in one pass: a few vector registers of any width.
const WIDTH: usize = 16;

type Wide = [f32; WIDTH];

/// What became of a lane's trial point.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Verdict {
    /// Taken as the new base; the next trial is set.
    Moves,
    /// So near that `landing` is the foot, at `height`.
    Lands,
    /// Worse than the base: nothing was changed.
    Fails,
}

fn load(from: &[f32; BATCH], first: usize) -> Wide {
    *from[first..].first_chunk().expect("passes divide the batch")
}

fn store(wide: Wide, to: &mut [f32; BATCH], first: usize) {
    to[first..first + WIDTH].copy_from_slice(&wide);
}

/// Judges all lanes' trial points by what was evaluated there, and sets the next ones.
///
/// With n the unit gradient and e = F/|∇F| at q, the zero set is near q the plane that p + s·n meets at
/// s = −(e + (p − q)·n): a full step goes there.
#[multiversion(targets = "simd")]
pub(super) fn judge(lanes: &mut Lanes, gradients: &Gradients, unit: f32) {
    let near = LAST_STEP * unit;
    let [least, greatest] = lanes.bounds;
    for first in (0..lanes.points.len).step_by(WIDTH) {
        let p = [0, 1, 2].map(|axis| load(&lanes.p[axis], first));
        let mut q = [&lanes.points.x, &lanes.points.y, &lanes.points.z].map(|array| load(array, first));
        let value = load(&gradients.value, first);
        let slope = [&gradients.dx, &gradients.dy, &gradients.dz].map(|array| load(array, first));
        let mut base = [0, 1, 2].map(|axis| load(&lanes.base[axis], first));
        let mut normal_step = [0, 1, 2].map(|axis| load(&lanes.normal_step[axis], first));
        let mut tangent_step = [0, 1, 2].map(|axis| load(&lanes.tangent_step[axis], first));
        let mut merit = load(&lanes.merit, first);
        let mut residual = load(&lanes.residual, first);
        let mut along = load(&lanes.along, first);
        let mut across = load(&lanes.across, first);
        let mut landing = [[0.0; WIDTH]; 3];
        let mut height = [0.0; WIDTH];
        let mut verdict = [0u32; WIDTH];
        for l in 0..WIDTH {
            let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            let at = |a: &[Wide; 3]| [a[0][l], a[1][l], a[2][l]];
            let inverse = 1.0 / dot(at(&slope), at(&slope)).sqrt();
            let n = at(&slope).map(|c| c * inverse);
            let e = value[l] * inverse;
            let towards = [0, 1, 2].map(|axis| p[axis][l] - q[axis][l]);
            let up = dot(towards, n);
            let tangent = [0, 1, 2].map(|axis| towards[axis] - n[axis] * up);
            // The distance to where the next step across the surface lands, and some doubt about landing there.
            let ahead = [0, 1, 2].map(|axis| towards[axis] + n[axis] * e);
            let new_merit = dot(ahead, ahead).sqrt() + 0.3 * e.abs();

            // A step that left the surface far (the more so the longer it was) has a merit not to be trusted.
            let before = at(&tangent_step);
            let length = along[l] * dot(before, before).sqrt();
            let strayed = e.abs() > 0.8 * residual[l] + 0.3 * length;
            let improves = (new_merit <= merit[l] * 1.0001) & !strayed;
            let approaches = (residual[l] > near) & (e.abs() < 0.8 * residual[l]);
            let taken = (new_merit < f32::INFINITY) & (improves | approaches);
            let lands = taken & (e.abs() <= near) & (dot(tangent, tangent) <= near * near);

            // The share of the tangential step that would have brought it to zero, were its change linear in the
            // step (the secant of Barzilai and Borwein); the greatest where the steps grow, as on the far side of
            // a ball.
            let change = [0, 1, 2].map(|axis| before[axis] - tangent[axis]);
            let (gain, size) = (dot(before, change), dot(change, change));
            #[allow(clippy::manual_clamp, reason = "0 / 0 becomes 0.1 so; a clamp would keep it")]
            let secant = (along[l] * gain / size).max(0.1).min(GREATEST_SHARE);
            let share = if gain <= 0.0 { GREATEST_SHARE } else { secant };
            let first_of_all = (merit[l] == f32::INFINITY) | (dot(before, before) == 0.0) | (size == 0.0);
            let share = if first_of_all { 1.0 } else { share };

            for axis in 0..3 {
                let trial = q[axis][l] - n[axis] * e + tangent[axis] * share;
                let trial = trial.max(least[axis]).min(greatest[axis]);
                base[axis][l] = if taken { q[axis][l] } else { base[axis][l] };
                q[axis][l] = if taken { trial } else { q[axis][l] };
                normal_step[axis][l] = if taken { -n[axis] * e } else { normal_step[axis][l] };
                tangent_step[axis][l] = if taken { tangent[axis] } else { tangent_step[axis][l] };
                landing[axis][l] = p[axis][l] - n[axis] * (e + up);
            }
            merit[l] = if taken { new_merit } else { merit[l] };
            residual[l] = if taken { e.abs() } else { residual[l] };
            along[l] = if taken { share } else { along[l] };
            across[l] = if taken { 1.0 } else { across[l] };
            height[l] = (e + up).abs();
            verdict[l] = if lands { 1 } else { 2 - 2 * u32::from(taken) };
        }
        for axis in 0..3 {
            store(base[axis], &mut lanes.base[axis], first);
            store(normal_step[axis], &mut lanes.normal_step[axis], first);
            store(tangent_step[axis], &mut lanes.tangent_step[axis], first);
            store(landing[axis], &mut lanes.landing[axis], first);
        }
        store(q[0], &mut lanes.points.x, first);
        store(q[1], &mut lanes.points.y, first);
        store(q[2], &mut lanes.points.z, first);
        store(merit, &mut lanes.merit, first);
        store(residual, &mut lanes.residual, first);
        store(along, &mut lanes.along, first);
        store(across, &mut lanes.across, first);
        store(height, &mut lanes.height, first);
        for (l, verdict) in verdict.into_iter().enumerate() {
            lanes.verdict[first + l] = [Verdict::Moves, Verdict::Lands, Verdict::Fails][verdict as usize];
        }
    }
}
