//! Where a morph's shape waits: a share of its span, smooth in space.

use std::fmt;
use std::sync::Arc;

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use super::coarse::CoarseGrid;
use super::settings::Error;
use crate::attribute::Scalar;
use crate::field::{Aabb, BATCH, Interval};

/// The longest wait. Longer: all of the change falls into a frame or two.
pub(super) const LONGEST: f64 = 0.95;

/// How long each place waits, as a share of the morph's eased progress in \[0, 0.95\]: it starts then, and ends with all
/// others. In world space, standing still.
#[derive(Clone)]
pub struct Delay(pub Arc<Scalar>);

impl fmt::Debug for Delay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Delay")
    }
}

/// The progress of a place that waits: 0 until `delay`, 1 at the end.
pub(super) fn progress(eased: f64, delay: f64) -> f64 {
    ((eased - delay) / (1.0 - delay)).clamp(0.0, 1.0)
}

/// By how much [`progress`] changes with the delay.
fn rate(eased: f64, delay: f64) -> f64 {
    if eased <= delay || eased >= 1.0 { 0.0 } else { -(1.0 - eased) / ((1.0 - delay) * (1.0 - delay)) }
}

/// A delay by its values at the middles of the coarse grid's cells, as the control points of a quadratic B-spline: C¹,
/// never beyond the values around, and so with bounds over any box.
pub(super) struct DelayGrid {
    grid: CoarseGrid,
    values: Vec<f32>,
}

/// The progress of a place, and its gradient in world units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    pub progress: f64,
    pub gradient: DVec3,
}

impl DelayGrid {
    /// Fails where the delay is out of its range, or not a number.
    pub(super) fn new(grid: &CoarseGrid, delay: &Delay) -> Result<Self, Error> {
        let mut values = vec![0.0; grid.cell_count()];
        values.par_chunks_mut(BATCH).enumerate().for_each_init(
            || (delay.0.sampler(), [[0.0]; BATCH]),
            |(sampler, batch), (block, values)| {
                let (points, region) = grid.block_points(block);
                sampler.enter(&region);
                sampler.sample(&points, batch);
                sampler.leave();
                values.copy_from_slice(batch.as_flattened());
            },
        );
        match values.iter().find(|value| !(0.0..=LONGEST as f32).contains(*value)) {
            Some(value) => Err(Error::Setting { name: "delay", value: f64::from(*value), least: 0.0, most: LONGEST }),
            None => Ok(Self { grid: grid.clone(), values }),
        }
    }

    /// How long the place of a coarse cell waits.
    fn at_cell(&self, cell: IVec3) -> f64 {
        let last = self.grid.size() - 1;
        f64::from(self.values[self.grid.cell(cell.clamp(IVec3::ZERO, last))])
    }

    /// The progress at a place in the world, when the morph's is `eased`.
    pub(super) fn local(&self, position: DVec3, eased: f64) -> Local {
        let (delay, slope) = self.at(position);
        Local { progress: progress(eased, delay), gradient: slope * rate(eased, delay) }
    }

    /// The time of colours at a place in the world: from 0 on, past 1 where the morph's is.
    pub(super) fn colour_time(&self, position: DVec3, time: f64) -> f64 {
        let (delay, _) = self.at(position);
        ((time - delay) / (1.0 - delay)).max(0.0)
    }

    /// The delay at a place in the world, and its gradient.
    fn at(&self, position: DVec3) -> (f64, DVec3) {
        let place = self.in_cells(position);
        let nearest = place.round();
        let from = place - nearest;
        // The three weights along each axis, and their rates.
        let (before, after) = (0.5 - from, 0.5 + from);
        let weights = [before * before * 0.5, 0.75 - from * from, after * after * 0.5];
        let rates = [-before, -2.0 * from, after];
        let (mut delay, mut slope) = (0.0, DVec3::ZERO);
        for x in 0..3 {
            for y in 0..3 {
                for z in 0..3 {
                    let step = IVec3::new(x, y, z) - 1;
                    let value = self.at_cell(nearest.as_ivec3() + step);
                    let [x, y, z] = [x, y, z].map(|i| i as usize);
                    let (wx, wy, wz) = (weights[x].x, weights[y].y, weights[z].z);
                    delay += value * wx * wy * wz;
                    slope += value * DVec3::new(rates[x].x * wy * wz, wx * rates[y].y * wz, wx * wy * rates[z].z);
                }
            }
        }
        (delay, slope / self.grid.edge())
    }

    /// Bounds of the progress over a box of the world.
    pub(super) fn bounds(&self, region: &Aabb, eased: f64) -> Interval {
        let first = (self.in_cells(region.min).round().as_ivec3() - 1).max(IVec3::ZERO);
        let last = (self.in_cells(region.max).round().as_ivec3() + 1).min(self.grid.size() - 1);
        let mut delays = Interval::new(f64::INFINITY, f64::NEG_INFINITY);
        for x in first.x..=last.x {
            for y in first.y..=last.y {
                for z in first.z..=last.z {
                    let delay = self.at_cell(IVec3::new(x, y, z));
                    delays = delays.union(Interval::new(delay, delay));
                }
            }
        }
        Interval::new(progress(eased, delays.hi), progress(eased, delays.lo))
    }

    /// A place in cells from the middle of the first one, held to the grid: beyond it the delay is that of its faces.
    fn in_cells(&self, position: DVec3) -> DVec3 {
        self.grid.in_cells(position).clamp(DVec3::ZERO, (self.grid.size() - 1).as_dvec3())
    }
}
