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
    /// By x, y and z, with a cell more at each end, which has its neighbour's.
    values: Vec<f32>,
}

/// The values of a grid's cells as a [`DelayGrid`] keeps them.
fn beyond_faces(grid: &CoarseGrid, values: &[f32]) -> Vec<f32> {
    let last = grid.size() - 1;
    let along = |axis: usize| -1..=last[axis] + 1;
    let value = |cell: IVec3| values[grid.cell(cell.clamp(IVec3::ZERO, last))];
    along(0).flat_map(|x| along(1).flat_map(move |y| along(2).map(move |z| IVec3::new(x, y, z)))).map(value).collect()
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
            None => Ok(Self { grid: grid.clone(), values: beyond_faces(grid, &values) }),
        }
    }

    /// Where the value of a coarse cell stands, or of one a step beyond the grid.
    fn place(&self, cell: IVec3) -> usize {
        let ([x, y, z], size) = ((cell + 1).to_array().map(|at| at as usize), self.grid.size() + 2);
        (x * size.y as usize + y) * size.z as usize + z
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
        let first = nearest.as_ivec3() - 1;
        let around = [0, 1, 2].map(|x| {
            [0, 1, 2].map(|y| {
                let row = self.place(first + IVec3::new(x, y, 0));
                [0, 1, 2].map(|z| f64::from(self.values[row + z]))
            })
        });
        let from = place - nearest;
        // The three weights along each axis, and their rates.
        let (before, after) = (0.5 - from, 0.5 + from);
        let weights = [before * before * 0.5, 0.75 - from * from, after * after * 0.5];
        let rates = [-before, -2.0 * from, after];
        let along = |values: [f64; 3], by: &[DVec3; 3], axis: usize| {
            values[0] * by[0][axis] + values[1] * by[1][axis] + values[2] * by[2][axis]
        };
        let along_z = |by: &[DVec3; 3]| around.map(|plane| plane.map(|row| along(row, by, 2)));
        let along_y = |plane: [[f64; 3]; 3], by: &[DVec3; 3]| plane.map(|row| along(row, by, 1));
        let plane = along_z(&weights);
        let row = along_y(plane, &weights);
        let slope = DVec3::new(
            along(row, &rates, 0),
            along(along_y(plane, &rates), &weights, 0),
            along(along_y(along_z(&rates), &weights), &weights, 0),
        );
        (along(row, &weights, 0), slope / self.grid.edge())
    }

    /// Bounds of the progress over a box of the world.
    pub(super) fn bounds(&self, region: &Aabb, eased: f64) -> Interval {
        let first = (self.in_cells(region.min).round().as_ivec3() - 1).max(IVec3::ZERO);
        let last = (self.in_cells(region.max).round().as_ivec3() + 1).min(self.grid.size() - 1);
        let mut delays = Interval::new(f64::INFINITY, f64::NEG_INFINITY);
        for x in first.x..=last.x {
            for y in first.y..=last.y {
                for z in first.z..=last.z {
                    let delay = f64::from(self.values[self.place(IVec3::new(x, y, z))]);
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
