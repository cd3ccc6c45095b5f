//! Whose material stands where: the pieces of a faceted shape, asked by position.

use super::super::cells::{CellId, Cells};
use super::super::{Aabb, BATCH, Expression, Field, Points};
use super::cut::{OVERLAP, Piece};

/// The pieces of a faceted shape.
///
/// A piece reaches a little over the border of its cell ([`OVERLAP`]), so the wall of a step lies in the cell in front
/// of it: the cell that holds a position is not always the one whose material is there.
#[derive(Clone)]
pub struct Pieces {
    shape: Expression,
    /// In the order of their cells.
    pub(super) pieces: Vec<Piece>,
    /// No piece reaches farther over the border of its cell, world units.
    reach: f64,
}

impl Pieces {
    pub(super) fn new(shape: Expression, pieces: Vec<Piece>, cells: &Cells) -> Self {
        let longest = pieces.iter().map(|piece| cells.cell(piece.cell).bounds.size().x).fold(0.0, f64::max);
        // Half as much again, for points that are a rounding error off the wall.
        Self { shape, pieces, reach: 1.5 * OVERLAP * longest }
    }

    /// The surface cell that each point belongs to: the one it lies in, or the one beside it whose piece holds a point
    /// that its own cell's piece does not.
    pub fn cells_at(&self, cells: &Cells, points: &Points, out: &mut [u32; BATCH]) {
        let Some(region) = points.bounding_box() else { return };
        cells.surface_leaves_at(points, &region, out);
        // Mostly all points belong to one cell, or to none.
        let first = out[0];
        if out[..points.len].iter().all(|&cell| cell == first) && self.holds_alone(cells, CellId(first), &region) {
            return;
        }
        let root = cells.root();
        let mut values = None;
        for i in 0..points.len {
            let (position, own) = (points.position(i), CellId(out[i]));
            let point = Aabb::new(position, position);
            if self.holds_alone(cells, own, &point) {
                continue;
            }
            let around = point.grown(self.reach);
            let around = Aabb::new(around.min.clamp(root.min, root.max), around.max.clamp(root.min, root.max));
            // One search for most, in place of one for each corner.
            if cells.surface_leaves_near(&around) == [own] {
                continue;
            }
            let beside = around.corners().map(|corner| cells.surface_leaf_from(corner, own));
            if beside.iter().all(|&cell| cell == own) {
                continue;
            }
            let values = values.get_or_insert_with(|| {
                let mut values = [0.0; BATCH];
                self.shape.evaluator().values(points, &mut values);
                values
            });
            let holds = |cell: &CellId| {
                let piece = self.pieces.binary_search_by_key(cell, |piece| piece.cell);
                piece.is_ok_and(|at| self.pieces[at].value(position, f64::from(values[i])) >= -self.reach)
            };
            if !holds(&own)
                && let Some(other) = beside.iter().find(|cell| holds(cell))
            {
                out[i] = other.0;
            }
        }
    }

    /// Whether a region, whose points lie nearest to a cell, is one that no other cell's piece reaches into: so deep in its
    /// cell, or so far from it that no piece does.
    fn holds_alone(&self, cells: &Cells, own: CellId, region: &Aabb) -> bool {
        let bounds = cells.cell(own).bounds;
        let deep = bounds.grown(-self.reach);
        let deep = deep.contains(region.min) && deep.contains(region.max);
        deep || bounds.grown(2.0 * self.reach).intersection(*region).is_none()
    }
}
