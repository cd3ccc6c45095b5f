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

/// Cells in a block along each axis: one batch.
const CUBE: IVec3 = IVec3::splat(BLOCK_EDGE);
/// The same of a grid over the plane.
const SQUARE: IVec3 = IVec3::new(32, 16, 1);

/// Cubic cells in blocks of one batch each, or one layer of square ones over the plane z = 0; within a block a cell's place
/// goes by x, y and z.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CoarseGrid {
    least: [f64; 3],
    edge: f64,
    blocks: [i32; 3],
    /// How far cells of the plane reach along z, world units.
    depth: Option<f64>,
}

impl CoarseGrid {
    /// Cells over a box, and a little more; of so much depth over its part of the plane z = 0.
    pub(super) fn over(aabb: Aabb, depth: Option<f64>) -> Self {
        let aabb = if depth.is_some() { aabb.at_z(0.0) } else { aabb };
        let size = aabb.size();
        let longest = size.max_element();
        let filled = size.max(DVec3::splat(longest * 1e-3));
        let (edge, block) = match depth {
            None => (libm::cbrt(filled.element_product() / CELLS), CUBE),
            Some(_) => ((filled.x * filled.y / CELLS).sqrt(), SQUARE),
        };
        let edge = edge.max(longest / LONGEST);
        let block = block.as_dvec3() * edge;
        let blocks = (size / block).ceil().max(DVec3::ONE);
        let half = blocks * block * 0.5;
        Self { least: (aabb.centre() - half).to_array(), edge, blocks: blocks.as_ivec3().to_array(), depth }
    }

    /// How far cells of the plane reach along z, world units; `None` of cubes.
    pub(super) fn depth(&self) -> Option<f64> {
        self.depth
    }

    fn block_size(&self) -> IVec3 {
        if self.depth.is_some() { SQUARE } else { CUBE }
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
        self.edge * self.edge * self.depth.unwrap_or(self.edge)
    }

    pub(super) fn block_count(&self) -> usize {
        self.blocks.iter().map(|n| *n as usize).product()
    }

    pub(super) fn cell_count(&self) -> usize {
        self.block_count() * BATCH
    }

    /// How many cells there are along each axis.
    pub(super) fn size(&self) -> IVec3 {
        IVec3::from_array(self.blocks) * self.block_size()
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
        let size = self.block_size();
        self.block(cell / BATCH) * size + within(size, cell % BATCH)
    }

    /// Whether a cell lies on a face of the grid.
    pub(super) fn on_face(&self, cell: usize) -> bool {
        let voxel = self.voxel(cell);
        let last = self.size() - 1;
        let faces = voxel.cmpeq(IVec3::ZERO) | voxel.cmpeq(last);
        // In the plane nothing spreads along z.
        faces.x || faces.y || (faces.z && self.depth.is_none())
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
        let size = self.block_size();
        let (block, local) = (voxel / size, voxel % size);
        let [_, ny, nz] = self.blocks;
        let block = (block.x * ny + block.y) * nz + block.z;
        block as usize * BATCH + ((local.x * size.y + local.y) * size.z + local.z) as usize
    }

    pub(super) fn block_points(&self, index: usize) -> (Points, Aabb) {
        let size = self.block_size();
        let half_block = size.as_dvec3() * self.edge * 0.5;
        let middle = DVec3::from_array(self.least) + (self.block(index).as_dvec3() + 0.5) * (half_block * 2.0);
        let mut points = Points::new(middle);
        let first = (size - 1).as_dvec3() * 0.5;
        for i in 0..BATCH {
            let offset = (within(size, i).as_dvec3() - first) * self.edge;
            (points.x[i], points.y[i], points.z[i]) = offset.as_vec3().into();
        }
        points.len = BATCH;
        (points, Aabb::new(middle - half_block, middle + half_block))
    }
}

/// Where in a block of a size a cell is.
fn within(size: IVec3, cell: usize) -> IVec3 {
    let [y, z] = [size.y, size.z].map(|size| size as usize);
    IVec3::new((cell / (y * z)) as i32, (cell / z % y) as i32, (cell % z) as i32)
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
