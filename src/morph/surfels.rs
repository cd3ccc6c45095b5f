//! How far a surface goes from one frame to the next, by discs on both.
//!
//! A disc is a point of F = 0 with the normal there, one for each cell of the coarse grid near the surface, and as wide as
//! a cell. The distance from one surface to the other is the greatest from a disc's point to the nearest disc of the
//! other: what appears or vanishes counts by how far it is from what is there. Exact where a surface is flat at the size
//! of a cell; at edges and in bends it is off by a part of a cell.

use glam::DVec3;
use rayon::prelude::*;

use super::coarse::CoarseGrid;
use super::motion::Similarity;
use crate::field::{BATCH, Field, Gradients};

/// Newton steps from a cell's middle to the surface.
const STEPS: usize = 4;

/// A point of a surface, and the unit normal there.
#[derive(Clone, Copy, Debug)]
struct Disc {
    point: DVec3,
    normal: DVec3,
}

/// A surface's discs, in order of x.
pub(super) struct Surfels {
    radius: f64,
    discs: Vec<Disc>,
}

impl Surfels {
    /// The discs of a field's surface on a coarse grid.
    pub(super) fn new(grid: &CoarseGrid, field: &dyn Field) -> Self {
        let edge = grid.edge();
        let found: Vec<Vec<Disc>> = (0..grid.block_count())
            .into_par_iter()
            .map_init(
                || (field.evaluator(), Gradients::new()),
                |(evaluator, gradients), block| {
                    let (mut points, region) = grid.block_points(block);
                    let region = region.grown(edge);
                    evaluator.enter(&region);
                    let bounds = evaluator.bounds();
                    let mut discs = Vec::new();
                    if bounds.contains(0.0) {
                        let middles = points.clone();
                        for _ in 0..STEPS {
                            evaluator.gradients(&points, gradients);
                            for i in 0..BATCH {
                                let gradient = gradients.gradient(i);
                                let step = -gradient * (gradients.value[i] / gradient.length_squared().max(1e-20));
                                let from = middles.offset(i);
                                let place = (points.offset(i) + step.clamp_length_max(edge as f32) - from)
                                    .clamp(glam::Vec3::splat(-edge as f32), glam::Vec3::splat(edge as f32));
                                let place = from + place;
                                (points.x[i], points.y[i], points.z[i]) = (place.x, place.y, place.z);
                            }
                        }
                        evaluator.gradients(&points, gradients);
                        for i in 0..BATCH {
                            let gradient = gradients.gradient(i).as_dvec3();
                            let off = f64::from(gradients.value[i]).abs();
                            if off <= 0.01 * edge * gradient.length() && gradient.length() > 0.0 {
                                discs.push(Disc { point: points.position(i), normal: gradient.normalize() });
                            }
                        }
                    }
                    evaluator.leave();
                    discs
                },
            )
            .collect();
        let mut discs = found.concat();
        discs.sort_by(|a, b| a.point.x.total_cmp(&b.point.x));
        Self { radius: 0.5 * edge, discs }
    }

    /// The same, placed.
    pub(super) fn carried(mut self, placement: &Similarity) -> Self {
        for disc in &mut self.discs {
            disc.point = placement.to_world(disc.point);
            disc.normal = placement.rotation() * disc.normal;
        }
        self.discs.sort_by(|a, b| a.point.x.total_cmp(&b.point.x));
        self
    }

    /// The greatest distance from a point of either surface to the other, world units; 0 where one has none.
    pub(super) fn farthest(&self, other: &Self) -> f64 {
        if self.discs.is_empty() || other.discs.is_empty() {
            return 0.0;
        }
        let reach =
            |from: &Self, to: &Self| from.discs.par_iter().map(|disc| to.distance(disc.point)).reduce(|| 0.0, f64::max);
        reach(self, other).max(reach(other, self))
    }

    /// The distance from a point to the nearest disc, looked for to both sides along x as far as one can be nearer.
    fn distance(&self, point: DVec3) -> f64 {
        let middle = self.discs.partition_point(|disc| disc.point.x < point.x);
        let (before, after) = self.discs.split_at(middle);
        let mut nearest = f64::INFINITY;
        let mut look = |disc: &Disc| {
            // No disc is nearer than its middle less its radius: few are looked at closely.
            let reach = nearest + self.radius;
            if (disc.point - point).length_squared() <= reach * reach {
                nearest = nearest.min(to_disc(disc, point, self.radius));
            }
            (disc.point.x - point.x).abs() <= nearest + self.radius
        };
        before.iter().rev().take_while(|disc| look(disc)).for_each(drop);
        after.iter().take_while(|disc| look(disc)).for_each(drop);
        nearest
    }
}

fn to_disc(disc: &Disc, point: DVec3, radius: f64) -> f64 {
    let from = point - disc.point;
    let above = from.dot(disc.normal);
    let beside = ((from - disc.normal * above).length() - radius).max(0.0);
    (above * above + beside * beside).sqrt()
}
