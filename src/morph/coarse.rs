//! The fixed coarse grid over a morph's shot, on which volume and change are measured.
//!
//! It depends on the two objects and their motion alone: not on the resolution, the frames asked for, or the threads.

use glam::{DVec3, IVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::distance::Distance;
use crate::field::{Aabb, BATCH, Gradients, Points};
use crate::grid::BLOCK_EDGE;

/// Cells aimed at. Fewer and thin objects are measured badly; more and planning a shot takes seconds.
const CELLS: f64 = 150_000.0;
/// The most cells along one axis, for boxes that are nearly flat or nearly a line.
const LONGEST: f64 = 768.0;

/// Cubic cells in blocks of 8³, one batch each; a cell's place is `block·512 + x·64 + y·8 + z`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CoarseGrid {
    least: [f64; 3],
    edge: f64,
    blocks: [i32; 3],
}

impl CoarseGrid {
    /// Cells over a box, and a little more.
    pub(super) fn over(aabb: Aabb) -> Self {
        let size = aabb.size();
        let longest = size.max_element();
        let filled = size.max(DVec3::splat(longest * 1e-3));
        let edge = libm::cbrt(filled.element_product() / CELLS).max(longest / LONGEST);
        let blocks = (size / (edge * f64::from(BLOCK_EDGE))).ceil().max(DVec3::ONE);
        let half = blocks * (edge * f64::from(BLOCK_EDGE) * 0.5);
        Self { least: (aabb.centre() - half).to_array(), edge, blocks: blocks.as_ivec3().to_array() }
    }

    /// All of it.
    pub(super) fn aabb(&self) -> Aabb {
        let least = DVec3::from_array(self.least);
        Aabb::new(least, least + self.size().as_dvec3() * self.edge)
    }

    /// A cell's edge, world units.
    pub fn edge(&self) -> f64 {
        self.edge
    }

    /// A cell's volume, cubic world units.
    pub fn cell_volume(&self) -> f64 {
        self.edge * self.edge * self.edge
    }

    pub(super) fn block_count(&self) -> usize {
        self.blocks.iter().map(|n| *n as usize).product()
    }

    pub(super) fn cell_count(&self) -> usize {
        self.block_count() * BATCH
    }

    /// How many cells there are along each axis.
    pub(super) fn size(&self) -> IVec3 {
        IVec3::from_array(self.blocks) * BLOCK_EDGE
    }

    /// A place in the world, in cells from the middle of the first cell.
    pub(super) fn in_cells(&self, position: DVec3) -> DVec3 {
        (position - DVec3::from_array(self.least)) / self.edge - 0.5
    }

    fn block(&self, index: usize) -> IVec3 {
        let [_, ny, nz] = self.blocks.map(|n| n as usize);
        IVec3::new((index / (ny * nz)) as i32, (index / nz % ny) as i32, (index % nz) as i32)
    }

    /// A cell's middle.
    pub(super) fn centre(&self, cell: usize) -> DVec3 {
        DVec3::from_array(self.least) + (self.voxel(cell).as_dvec3() + 0.5) * self.edge
    }

    fn voxel(&self, cell: usize) -> IVec3 {
        let local = cell % BATCH;
        let within = IVec3::new((local >> 6) as i32, (local >> 3 & 7) as i32, (local & 7) as i32);
        self.block(cell / BATCH) * BLOCK_EDGE + within
    }

    /// Whether a cell lies on a face of the grid.
    pub(super) fn on_face(&self, cell: usize) -> bool {
        let voxel = self.voxel(cell);
        let last = self.size() - 1;
        voxel.cmpeq(IVec3::ZERO).any() || voxel.cmpeq(last).any()
    }

    /// A distance at the cells' middles, in units of D; `unit` is D.
    pub(super) fn sampled(&self, distance: &dyn Distance, unit: f64) -> Vec<f32> {
        let mut values = vec![0.0; self.cell_count()];
        let per_unit = (1.0 / unit) as f32;
        values.par_chunks_mut(BATCH).enumerate().for_each_init(
            || (distance.evaluator(), [0.0; BATCH]),
            |(evaluator, out), (block, values)| {
                let (points, region) = self.block_points(block);
                evaluator.enter(&region);
                evaluator.values(&points, out);
                evaluator.leave();
                values.iter_mut().zip(&*out).for_each(|(value, out)| *value = out * per_unit);
            },
        );
        values
    }

    /// How many parts of face-connected cells there are among those that are at least half inside.
    pub(super) fn pieces(&self, fractions: &[f32]) -> usize {
        let size = self.size();
        let mut open: Vec<bool> = fractions.iter().map(|fraction| *fraction >= 0.5).collect();
        let (mut pieces, mut stack) = (0, Vec::new());
        for start in 0..open.len() {
            if !std::mem::take(&mut open[start]) {
                continue;
            }
            pieces += 1;
            stack.push(start);
            while let Some(cell) = stack.pop() {
                let voxel = self.voxel(cell);
                for step in [IVec3::X, IVec3::Y, IVec3::Z].into_iter().flat_map(|axis| [axis, -axis]) {
                    let next = voxel + step;
                    if next.cmpge(IVec3::ZERO).all() && next.cmplt(size).all() {
                        let next = self.cell(next);
                        if std::mem::take(&mut open[next]) {
                            stack.push(next);
                        }
                    }
                }
            }
        }
        pieces
    }

    /// The place of a voxel's cell.
    pub(super) fn cell(&self, voxel: IVec3) -> usize {
        let (block, local) = (voxel / BLOCK_EDGE, voxel % BLOCK_EDGE);
        let [_, ny, nz] = self.blocks;
        let block = (block.x * ny + block.y) * nz + block.z;
        block as usize * BATCH + (local.x * 64 + local.y * 8 + local.z) as usize
    }

    pub(super) fn block_points(&self, index: usize) -> (Points, Aabb) {
        let half_block = self.edge * f64::from(BLOCK_EDGE) * 0.5;
        let middle =
            DVec3::from_array(self.least) + (self.block(index).as_dvec3() + 0.5) * (self.edge * f64::from(BLOCK_EDGE));
        let mut points = Points::new(middle);
        let offset = |i: usize| ((i as f64 - 3.5) * self.edge) as f32;
        for i in 0..BATCH {
            points.x[i] = offset(i >> 6);
            points.y[i] = offset((i >> 3) & 7);
            points.z[i] = offset(i & 7);
        }
        points.len = BATCH;
        (points, Aabb::new(middle - half_block, middle + half_block))
    }
}

/// Both objects' distances at the cells' middles, in units of D, and the cosine between their gradients: all that
/// the section of a morph depends on.
pub struct Measured {
    pub first: Vec<f32>,
    pub second: Vec<f32>,
    pub cosine: Vec<f32>,
}

impl Measured {
    /// Measures two distances that stand in the world; `unit` is D.
    pub(super) fn new(grid: &CoarseGrid, first: &dyn Distance, second: &dyn Distance, unit: f64) -> Self {
        let cells = grid.cell_count();
        let mut measured = Self { first: vec![0.0; cells], second: vec![0.0; cells], cosine: vec![0.0; cells] };
        let per_unit = (1.0 / unit) as f32;
        measured
            .first
            .par_chunks_mut(BATCH)
            .zip(measured.second.par_chunks_mut(BATCH))
            .zip(measured.cosine.par_chunks_mut(BATCH))
            .enumerate()
            .for_each_init(
                || (first.evaluator(), second.evaluator(), Gradients::new(), Gradients::new()),
                |(first, second, one, two), (block, ((out_first, out_second), out_cosine))| {
                    let (points, region) = grid.block_points(block);
                    first.enter(&region);
                    first.gradients(&points, one);
                    first.leave();
                    second.enter(&region);
                    second.gradients(&points, two);
                    second.leave();
                    for i in 0..BATCH {
                        out_first[i] = one.value[i] * per_unit;
                        out_second[i] = two.value[i] * per_unit;
                        let (a, b) = (one.gradient(i), two.gradient(i));
                        let lengths = (a.length_squared() * b.length_squared()).sqrt().max(f32::MIN_POSITIVE);
                        out_cosine[i] = (a.dot(b) / lengths).clamp(-1.0, 1.0);
                    }
                },
            );
        measured
    }
}
