//! Cuts that would leave crumbs (material that hangs on nothing) or hollows (holes nobody sees) are taken back.
//!
//! The pieces are tried on a grid of samples; each loose part of the solid or of the space around it that the shape
//! itself does not have makes the cells around it whole, until there is none.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec3, IVec3, UVec3};

use super::super::cells::{CellId, Cells, Place};
use super::super::{Aabb, BATCH, Field, Points};
use super::Options;
use super::cut::{Piece, Support, piece};

/// Samples along an edge of the finest cells. Fewer would miss crumbs, more take cubically longer.
const SAMPLES_PER_CELL: u32 = 6;
/// The most samples along an edge of the root.
const MOST_SAMPLES: u32 = 128;

/// All pieces of a faceted shape, free of crumbs and hollows as far as samples tell, and how many cells were left
/// whole for it.
pub(super) fn sound_pieces(field: &dyn Field, cells: &Cells, options: &Options) -> (Vec<Piece>, usize) {
    let mut evaluator = field.evaluator();
    let mut pieces: BTreeMap<CellId, Piece> = BTreeMap::new();
    let mut supports = BTreeMap::new();
    for (id, cell) in (0..).map(CellId).zip(cells.cells()) {
        match cell.place {
            Place::Surface => {
                let (piece, support) = piece(evaluator.as_mut(), cells, id, options);
                pieces.insert(id, piece);
                supports.insert(id, support);
            }
            Place::Inside => {
                pieces.insert(id, Piece::whole(cells, id));
            }
            Place::Outside => {}
        }
    }
    share_cuts(&mut pieces, &supports, cells, options);
    let mut pieces: Vec<Piece> = pieces.into_values().collect();
    let grid = Grid::new(cells, options.cut);
    let shape = grid.values(field);
    let mut whole = BTreeSet::new();
    loop {
        let faceted = grid.values_of(&pieces, &shape);
        let loose = loose_cells(&grid, cells, &shape, &faceted);
        let before = whole.len();
        whole.extend(loose);
        if whole.len() == before {
            let mended = pieces.iter().filter(|piece| whole.contains(&piece.cell)).count();
            return (pieces, mended);
        }
        for piece in pieces.iter_mut().filter(|piece| whole.contains(&piece.cell)) {
            *piece = Piece::whole(cells, piece.cell);
        }
    }
}

/// Cells that the shape only reaches into a little, less than the cell below may be cut, get that cell's cut: cut on
/// their own they would float, and left whole they would roof it over.
fn share_cuts(
    pieces: &mut BTreeMap<CellId, Piece>,
    supports: &BTreeMap<CellId, Support>,
    cells: &Cells,
    options: &Options,
) {
    // A cell below may be shallow itself; more than a few steps are a shape that is thin everywhere.
    const MOST_STEPS: usize = 4;
    let below = |id: CellId| {
        let support = supports.get(&id)?;
        let below = cells.leaf_at(support.below);
        let deepest_cut = options.cut.min(cells.cell(below).bounds.size().x * 0.5);
        (below != id && support.depth < deepest_cut && supports.contains_key(&below)).then_some(below)
    };
    for &id in supports.keys() {
        let Some(first) = below(id) else { continue };
        let steps = std::iter::successors(Some(first), |&next| below(next));
        let base = steps.take(MOST_STEPS).last().unwrap_or(first);
        let cut = pieces[&base].clone();
        pieces.entry(id).and_modify(|piece| {
            *piece = Piece { planes: cut.planes, depth: cut.depth, ..Piece::whole(cells, id) };
        });
    }
}

/// A grid of samples over the root and a margin, x slowest.
struct Grid {
    origin: DVec3,
    spacing: f64,
    size: IVec3,
}

impl Grid {
    fn new(cells: &Cells, cut: f64) -> Self {
        let finest = cells.cells().iter().map(|cell| cell.depth).max().unwrap_or(0);
        let along = (SAMPLES_PER_CELL << finest).min(MOST_SAMPLES);
        let edge = cells.root().size().x;
        let spacing = edge / f64::from(along);
        // Samples keep off the walls of cells; the margin holds what grows out of the root and a layer of nothing.
        let margin = (cut.clamp(0.0, edge) / spacing).ceil() as u32 + 2;
        let size = UVec3::splat(along + 2 * margin).as_ivec3();
        Self { origin: cells.root().min - (f64::from(margin) - 0.5) * spacing, spacing, size }
    }

    fn len(&self) -> usize {
        self.size.as_usizevec3().element_product()
    }

    fn index(&self, at: IVec3) -> usize {
        ((at.x * self.size.y + at.y) * self.size.z + at.z) as usize
    }

    fn at(&self, index: usize) -> IVec3 {
        let (z, rest) = (index as i32 % self.size.z, index as i32 / self.size.z);
        IVec3::new(rest / self.size.y, rest % self.size.y, z)
    }

    fn position(&self, index: usize) -> DVec3 {
        self.origin + self.at(index).as_dvec3() * self.spacing
    }

    /// The field's values; what is out of its bounds is −∞ without asking.
    fn values(&self, field: &dyn Field) -> Vec<f32> {
        let mut evaluator = field.evaluator();
        let mut values = vec![f32::NEG_INFINITY; self.len()];
        let mut out = [0.0; BATCH];
        // A run of samples along z at a time, which is short enough for offsets and coherent enough for meshes.
        for run in (0..self.len()).step_by(self.size.z as usize) {
            for first in (run..run + self.size.z as usize).step_by(BATCH) {
                let count = (run + self.size.z as usize - first).min(BATCH);
                let mut points = Points::new(self.position(first));
                (0..count).for_each(|i| points.push(glam::Vec3::Z * (i as f64 * self.spacing) as f32));
                evaluator.values(&points, &mut out);
                values[first..first + count].copy_from_slice(&out[..count]);
            }
        }
        values
    }

    /// The values of the union of pieces.
    fn values_of(&self, pieces: &[Piece], shape: &[f32]) -> Vec<f32> {
        let deepest = pieces.iter().map(|piece| piece.depth).fold(0.0, f64::max) as f32;
        let mut values: Vec<f32> = shape.iter().map(|value| value - deepest).collect();
        for piece in pieces {
            self.each_in(piece.bounds, |index| {
                let value = piece.value(self.position(index), f64::from(shape[index])) as f32;
                values[index] = values[index].max(value);
            });
        }
        values
    }

    fn each_in(&self, bounds: Aabb, mut visit: impl FnMut(usize)) {
        let first = ((bounds.min - self.origin) / self.spacing).floor().as_ivec3().max(IVec3::ZERO);
        let last = ((bounds.max - self.origin) / self.spacing).ceil().as_ivec3().min(self.size - 1);
        for x in first.x..=last.x {
            for y in first.y..=last.y {
                for z in first.z..=last.z {
                    visit(self.index(IVec3::new(x, y, z)));
                }
            }
        }
    }

    /// The six beside a sample, not those across edges and corners: what hangs on by an edge shall count as loose.
    fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> {
        let at = self.at(index);
        let steps = [IVec3::X, -IVec3::X, IVec3::Y, -IVec3::Y, IVec3::Z, -IVec3::Z];
        let within = move |p: &IVec3| p.cmpge(IVec3::ZERO).all() && p.cmplt(self.size).all();
        steps.into_iter().map(move |step| at + step).filter(within).map(|p| self.index(p))
    }

    /// Numbers the connected parts of the solid and of the space around it, and counts their samples.
    fn parts(&self, values: &[f32]) -> (Vec<u32>, Vec<usize>) {
        const NONE: u32 = u32::MAX;
        let mut part = vec![NONE; values.len()];
        let mut sizes = Vec::new();
        let mut open = Vec::new();
        for start in 0..values.len() {
            if part[start] != NONE {
                continue;
            }
            let number = sizes.len() as u32;
            part[start] = number;
            sizes.push(0);
            open.push(start);
            while let Some(index) = open.pop() {
                sizes[number as usize] += 1;
                for next in self.neighbours(index) {
                    if part[next] == NONE && (values[next] >= 0.0) == (values[index] >= 0.0) {
                        part[next] = number;
                        open.push(next);
                    }
                }
            }
        }
        (part, sizes)
    }
}

/// The cells around those parts of the faceted solid, and of the space around it, that are not the largest remnant of
/// a part of the shape or of its surroundings.
fn loose_cells(grid: &Grid, cells: &Cells, shape: &[f32], faceted: &[f32]) -> BTreeSet<CellId> {
    let (shape_part, shape_sizes) = grid.parts(shape);
    let (part, sizes) = grid.parts(faceted);
    // For each part of the shape, the largest faceted part on the same side that overlaps it.
    let mut remnant: Vec<Option<u32>> = vec![None; shape_sizes.len()];
    for index in 0..shape.len() {
        if (shape[index] >= 0.0) == (faceted[index] >= 0.0) {
            let best = &mut remnant[shape_part[index] as usize];
            let larger = |number: u32| best.is_none_or(|best| sizes[number as usize] > sizes[best as usize]);
            if larger(part[index]) {
                *best = Some(part[index]);
            }
        }
    }
    let kept: BTreeSet<u32> = remnant.into_iter().flatten().collect();
    let loose = (0..faceted.len()).filter(|&index| !kept.contains(&part[index]));
    let around = loose.flat_map(|index| grid.neighbours(index).chain([index]));
    around.map(|index| cells.leaf_at(grid.position(index))).collect()
}
