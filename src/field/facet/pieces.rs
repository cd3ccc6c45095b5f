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
        cells.surface_leaves_at(points, out);
        let mut values = None;
        for i in 0..points.len {
            let (position, own) = (points.position(i), CellId(out[i]));
            // No piece but its own reaches as far as this, or none at all.
            let bounds = cells.cell(own).bounds;
            if bounds.grown(-self.reach).contains(position) || !bounds.grown(2.0 * self.reach).contains(position) {
                continue;
            }
            let corners = Aabb::new(position, position).grown(self.reach).corners();
            let root = cells.root();
            let beside = corners.map(|corner| cells.surface_leaf_from(corner.clamp(root.min, root.max), own));
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
}
