//! How far a solid reaches from its z axis, slab by slab along it. Its box alone reaches too far at its corners.

use glam::{DVec2, DVec3};

use super::{Aabb, Evaluator, Expression, Field, Interval};

/// Slabs along z.
const SLABS: usize = 64;
/// Cells across the solid's width. More come nearer to it, in more time.
const CELLS: f64 = 16.0;
/// The most cells upon one another.
const MOST_HIGH: f64 = 1024.0;

/// Corners of cells around all that a solid has, slab by slab.
pub struct Silhouette {
    own: Aabb,
    slabs: Vec<Vec<DVec2>>,
}

impl Silhouette {
    /// Of a solid in a box.
    pub fn new(solid: &Expression, own: &Aabb) -> Self {
        let mut silhouette = Self { own: *own, slabs: vec![Vec::new(); SLABS] };
        let size = own.size();
        let across = size.x.max(size.y) / CELLS;
        let finest = DVec3::new(across, across, across.max(size.z / MOST_HIGH));
        silhouette.add(solid.evaluator().as_mut(), *own, finest);
        silhouette
    }

    /// The farthest corner's distance from the axis.
    pub fn reach(&self) -> f64 {
        self.slabs.iter().flatten().map(|corner| corner.length()).fold(0.0, f64::max)
    }

    /// The corners at a height.
    pub fn at(&self, z: f64) -> &[DVec2] {
        &self.slabs[self.slab(z)]
    }

    /// The corners between two heights.
    pub fn between(&self, low: f64, high: f64) -> impl Iterator<Item = &DVec2> {
        self.slabs[self.slab(low)..=self.slab(high)].iter().flatten()
    }

    fn slab(&self, z: f64) -> usize {
        let share = (z - self.own.min.z) / (self.own.max.z - self.own.min.z);
        ((share * SLABS as f64) as usize).min(SLABS - 1)
    }

    fn add(&mut self, evaluator: &mut dyn Evaluator, cell: Aabb, finest: DVec3) {
        evaluator.enter(&cell);
        let Interval { lo, hi } = evaluator.bounds();
        let longest = (cell.size() / finest).to_array();
        let axis = (0..3).fold(0, |most, axis| if longest[axis] > longest[most] { axis } else { most });
        if hi >= 0.0 && lo < 0.0 && longest[axis] > 1.0 {
            let middle = cell.centre()[axis];
            let (mut lower, mut upper) = (cell, cell);
            (lower.max[axis], upper.min[axis]) = (middle, middle);
            self.add(evaluator, lower, finest);
            self.add(evaluator, upper, finest);
        } else if hi >= 0.0 {
            let corners = [cell.min.x, cell.max.x].map(|x| [cell.min.y, cell.max.y].map(|y| DVec2::new(x, y)));
            let [low, high] = [cell.min.z, cell.max.z].map(|z| self.slab(z));
            for slab in &mut self.slabs[low..=high] {
                slab.extend(corners.as_flattened());
            }
        }
        evaluator.leave();
    }
}
