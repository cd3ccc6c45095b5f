//! Walls: zeros of F that are no surface.
//!
//! Where two parts of a union touch, F is 0 on the wall between them and positive on both sides: the solid goes on
//! there, and so do its distances. (F of an intersection of parts that touch from outside is the same with the signs
//! changed.) A candidate counts only when the other side of the surface is found beside it.

use glam::{Mat3, Vec3};

use crate::field::{BATCH, Evaluator, Gradients, Points};

use super::{
    Request,
    crease::{Queries, keep_lanes},
    lanes::Lane,
};

/// How far from a candidate the other side is looked for, in units. Smaller would meet the error of the candidate
/// itself, larger would take gaps and sheets for walls that are thicker than they need be.
const BESIDE: f32 = 0.04;

/// Sign patterns of three planes: the sectors into which they divide the neighbourhood of a common zero.
const SECTORS: usize = 8;

/// Candidates that are still in doubt.
pub(super) struct Scratch {
    /// Their lanes among the candidates.
    doubtful: Vec<u16>,
    confirmed: Box<[bool; BATCH]>,
    probes: Points,
}

impl Default for Scratch {
    fn default() -> Self {
        Self {
            doubtful: Vec::with_capacity(BATCH),
            confirmed: Box::new([false; BATCH]),
            probes: Points::new(glam::DVec3::ZERO),
        }
    }
}

impl Scratch {
    /// Leaves out the candidates on walls. `points` are candidates on the common zeros of two or three `branches`, of the
    /// queries in `group`; what F may be there by rounding, in `roundings`; `parts` and `values` are scratch memory.
    #[expect(clippy::too_many_arguments, reason = "the parts of one scratch memory")]
    pub fn leave_out(
        &mut self,
        evaluator: &mut dyn Evaluator,
        request: &Request,
        queries: &Queries,
        branches: &[u16],
        parts: &mut [Box<Gradients>; 3],
        points: &mut Points,
        group: &mut Vec<u16>,
        roundings: &Lane,
        values: &mut Lane,
        rejected: impl FnMut(u16),
    ) {
        let beside = BESIDE * request.unit;
        self.confirmed[..group.len()].fill(false);
        self.doubtful.clear();
        self.doubtful.extend(0..group.len() as u16);
        // Straight on from the query: on most creases the other side is there.
        let straight_on = |lane: usize| {
            let query = queries.points.offset(usize::from(group[lane]));
            points.offset(lane) - query
        };
        self.probe(evaluator, request, points, group, queries.inside, roundings, values, |lane| {
            straight_on(lane).normalize_or_zero() * beside
        });
        if !self.doubtful.is_empty() {
            for (part, &branch) in parts.iter_mut().zip(branches) {
                evaluator.branch(usize::from(branch), points, part);
            }
            for sector in 0..SECTORS >> (3 - branches.len()) {
                self.probe(evaluator, request, points, group, queries.inside, roundings, values, |lane| {
                    into_sector(parts, branches.len(), lane, sector) * beside
                });
            }
        }
        keep_lanes(points, group, |lane| self.confirmed[lane], rejected);
    }

    /// Confirms those of the candidates in doubt that have the other side a step away.
    #[expect(clippy::too_many_arguments, reason = "the parts of one scratch memory")]
    fn probe(
        &mut self,
        evaluator: &mut dyn Evaluator,
        request: &Request,
        points: &Points,
        group: &[u16],
        inside: &[bool; BATCH],
        roundings: &Lane,
        values: &mut Lane,
        step: impl Fn(usize) -> Vec3,
    ) {
        if self.doubtful.is_empty() {
            return;
        }
        let least = (request.region.min - points.origin).as_vec3();
        let greatest = (request.region.max - points.origin).as_vec3();
        (self.probes.origin, self.probes.len) = (points.origin, 0);
        for &lane in &self.doubtful {
            let lane = usize::from(lane);
            self.probes.push((points.offset(lane) + step(lane)).clamp(least, greatest));
        }
        evaluator.values(&self.probes, values);
        let mut probed = 0;
        let confirmed = &mut self.confirmed;
        self.doubtful.retain(|&lane| {
            let lane = usize::from(lane);
            let value = values[probed];
            confirmed[lane] = (value >= 0.0) != inside[usize::from(group[lane])] && value.abs() > roundings[lane];
            probed += 1;
            !confirmed[lane]
        });
    }
}

/// The unit vector into one of the sectors that two or three planes make, equally far from all of them.
fn into_sector(parts: &[Box<Gradients>; 3], planes: usize, lane: usize, sector: usize) -> Vec3 {
    let normal = |part: usize| parts[part].gradient(lane).normalize_or_zero();
    let side = |part: usize| if sector >> part & 1 == 0 { 1.0 } else { -1.0 };
    let (first, second) = (normal(0) * side(0), normal(1) * side(1));
    if planes == 2 {
        return (first + second).normalize_or_zero();
    }
    // v with n·v = 1 for all three normals.
    let normals = Mat3::from_cols(first, second, normal(2) * side(2)).transpose();
    let into = normals.inverse() * Vec3::ONE;
    if into.is_finite() { into.normalize_or_zero() } else { Vec3::ZERO }
}
