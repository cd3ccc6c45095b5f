//! Distances in the plane: a C¹ spline over a quadtree ([`Quadtree`]), for shapes whose F does not know z.
//!
//! What the [`octree`](crate::distance::octree) is in space: corners of cells have value and gradient of closest points and
//! mixed derivatives by differences, each cell is their bicubic Hermite patch, and a corner that hangs on the edge of a coarser
//! cell takes all four numbers from that (PHT splines; HFRep, section 6.1, Fig. 6 and 10).
//!
//! **Guaranteed:** one C¹ function of x and y everywhere, positive inside, bounded truly over boxes of its root; the same bits
//! for any number of threads. By [`Restore::Linear`] each cell is bilinear in its own corners instead, and the function jumps
//! where cells of different size meet. **Not guaranteed:** smallest cells across a crease round it, and cells across the medial
//! axis round that.

mod patch;

#[cfg(test)]
mod tests;

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use self::patch::{Jet, Patch};
use super::nearest::{ClosestPoint, Watch};
use super::octree::beyond::SATURATION;
use super::octree::corners::between;
use super::octree::refine::{LARGEST_AT_SURFACE, SLOPE_REACH};
use super::octree::samples::{Sample, Samples};
use super::octree::{BuildError, Report, Restore, Settings, root};
use super::{Distance, Foot};
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points};

/// Marks a node that is a leaf; the rest is the leaf's number.
const LEAF: u32 = 1 << 31;

/// A cell: its least corner and edge, in smallest cells.
#[derive(Clone, Copy, Debug)]
struct Cell {
    origin: [u32; 2],
    size: u32,
}

impl Cell {
    /// A corner: bit 2 for the greater x, 1 for y.
    fn corner(&self, corner: u32) -> [u32; 2] {
        [self.origin[0] + (corner >> 1) * self.size, self.origin[1] + (corner & 1) * self.size]
    }

    fn corners(&self) -> [[u32; 2]; 4] {
        [0, 1, 2, 3].map(|corner| self.corner(corner))
    }

    /// Its middle and those of its edges, which a cell of two smallest ones and more has.
    fn middles(&self) -> [[u32; 2]; 5] {
        let [x, y] = self.origin;
        let (half, whole) = (self.size / 2, self.size);
        [[x + half, y + half], [x, y + half], [x + whole, y + half], [x + half, y], [x + half, y + whole]]
    }

    fn child(&self, child: u32) -> Self {
        let size = self.size / 2;
        Self { origin: [self.origin[0] + (child >> 1) * size, self.origin[1] + (child & 1) * size], size }
    }

    /// Where in it a point of the lattice is, \[0, 1\] on each axis.
    fn within(&self, place: [u32; 2]) -> [f64; 2] {
        [0, 1].map(|axis| f64::from(place[axis] - self.origin[axis]) / f64::from(self.size))
    }
}

/// The signed distance to an outline, everywhere in the plane, as a C¹ spline.
#[derive(Debug)]
pub struct Quadtree {
    /// The root's least corner.
    origin: DVec2,
    /// The edge of a smallest cell.
    step: f64,
    /// The root's edge, in smallest cells.
    size: u32,
    /// The first of four children, or [`LEAF`] and the leaf's number.
    nodes: Vec<u32>,
    leaves: Vec<(Cell, Patch)>,
    restore: Restore,
    report: Report,
    /// The box around all that is inside.
    shape: Aabb,
}

impl Quadtree {
    /// Measures distances in the plane z = 0 by closest points of a field that does not know z, and that is nowhere positive
    /// outside of a box. Z is of no account.
    ///
    /// # Errors
    /// Those of an octree's building.
    pub fn build(
        oracle: &dyn ClosestPoint,
        shape: Aabb,
        settings: &Settings,
        watch: &Watch<'_>,
    ) -> Result<Self, BuildError> {
        let [min, max] = [settings.region.min, settings.region.max].map(|corner| corner.with_z(0.0));
        let settings = &Settings { region: Aabb::new(min, max), ..*settings };
        let (origin, depth) = root(settings)?;
        let mut samples = Samples::new(oracle, watch, origin.with_z(0.0), settings.smallest_cell);
        let mut growing = Growing {
            cells: vec![Cell { origin: [0; 2], size: 1 << depth }],
            children: vec![0],
            samples: &mut samples,
            settings,
        };
        growing.refine()?;
        let Growing { cells, children, .. } = growing;
        let mut nodes = Vec::with_capacity(cells.len());
        let mut leaves = Vec::new();
        for (cell, &first) in cells.iter().zip(&children) {
            nodes.push(if first == 0 { LEAF | leaves.len() as u32 } else { first });
            if first == 0 {
                leaves.push(*cell);
            }
        }
        let jets = Jets::new(&leaves, &samples, settings.smallest_cell);
        let smallest = leaves.iter().map(|leaf| leaf.size).min().unwrap_or(1);
        let mut tree = Self {
            origin: origin.truncate(),
            step: settings.smallest_cell,
            size: 1 << depth,
            nodes,
            leaves: Vec::new(),
            restore: settings.restore,
            shape: shape.without_z(),
            report: Report {
                cells: leaves.len(),
                corners: jets.jets.len(),
                samples: samples.len(),
                depth: depth - smallest.trailing_zeros(),
                ..Report::default()
            },
        };
        tree.restore(&leaves, jets);
        tree.report.bytes = size_of_val(&tree.nodes[..]) + size_of_val(&tree.leaves[..]);
        tree.measure(&samples);
        let is_inside = |sample: &Sample| sample.value >= 0.0;
        let count = (0..samples.len() as u32).filter(|&number| is_inside(samples.numbered(number))).count();
        if settings.levels.contains(0.0) && (count == 0 || count == samples.len()) {
            return Err(BuildError::NoSurface);
        }
        Ok(tree)
    }

    /// What was built.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Gives each leaf its patch: corners that hang first take their jets from the coarsest leaf on whose edge they are.
    fn restore(&mut self, leaves: &[Cell], Jets { mut jets, numbers }: Jets) {
        let own = leaves.iter().map(|leaf| leaf.corners().map(|corner| numbers[&corner]));
        let corners: Vec<[u32; 4]> = own.collect();
        let mut hanging: Vec<(u32, u32, [u32; 2])> = Vec::new();
        for (&place, &number) in &numbers {
            let around = self.leaves_around(place);
            let is_inner = |leaf: &u32| !leaves[*leaf as usize].corners().contains(&place);
            if let Some(leaf) = around.filter(is_inner).max_by_key(|&leaf| (leaves[leaf as usize].size, leaf)) {
                hanging.push((number, leaf, place));
            }
        }
        self.report.hanging = hanging.len();
        let edge = |leaf: u32| f64::from(leaves[leaf as usize].size) * self.step;
        let spline = |jets: &[Jet], leaf: u32| {
            Patch::hermite(corners[leaf as usize].map(|corner| &jets[corner as usize]), edge(leaf))
        };
        let values: Vec<f64> = jets.iter().map(|jet| jet[0]).collect();
        // Coarse leaves first: the corners of a leaf hang on larger ones only.
        hanging.sort_unstable_by_key(|&(number, leaf, _)| (std::cmp::Reverse(leaves[leaf as usize].size), number));
        for (number, leaf, place) in hanging {
            jets[number as usize] = spline(&jets, leaf).jet(leaves[leaf as usize].within(place), edge(leaf));
        }
        let patch = |leaf: u32| match self.restore {
            Restore::Spline => spline(&jets, leaf),
            Restore::Linear => Patch::bilinear(corners[leaf as usize].map(|corner| values[corner as usize])),
        };
        self.leaves = (0..).zip(leaves).map(|(leaf, cell)| (*cell, patch(leaf))).collect();
    }

    /// The leaves that a point of the lattice lies in or on, one to four times each.
    fn leaves_around(&self, place: [u32; 2]) -> impl Iterator<Item = u32> {
        let beside = move |axis: usize, step: u32| (place[axis] + step).checked_sub(1).filter(|&at| at < self.size);
        [[0, 0], [0, 1], [1, 0], [1, 1]]
            .into_iter()
            .filter_map(move |[x, y]| Some(self.leaf_of([beside(0, x)?, beside(1, y)?])))
    }

    /// The number of the leaf that holds a smallest cell.
    fn leaf_of(&self, [x, y]: [u32; 2]) -> u32 {
        let (mut node, mut half) = (self.nodes[0], self.size / 2);
        while node & LEAF == 0 {
            node = self.nodes[(node + 2 * u32::from(x & half != 0) + u32::from(y & half != 0)) as usize];
            half /= 2;
        }
        node & !LEAF
    }

    fn measure(&mut self, samples: &Samples<'_>) {
        let (mut at_surface, mut relative) = (0.0_f64, 0.0_f64);
        for ([x, y, _], sample) in
            (0..samples.len() as u32).map(|number| (samples.place(number), samples.numbered(number)))
        {
            let position = self.origin + DVec2::new(f64::from(x), f64::from(y)) * self.step;
            let error = (self.jet(position)[0] - sample.value).abs();
            if sample.value.abs() <= self.step {
                at_surface = at_surface.max(error);
            }
            relative = relative.max(error / sample.value.abs().max(self.step));
        }
        (self.report.error_at_surface, self.report.error_relative) = (at_surface, relative);
    }

    fn edge(&self) -> f64 {
        f64::from(self.size) * self.step
    }

    /// F, ∂y, ∂x, ∂xy at a position of the root.
    fn jet(&self, position: DVec2) -> Jet {
        let at = ((position - self.origin) / self.step).to_array();
        let last = self.size - 1;
        let (cell, patch) = &self.leaves[self.leaf_of(at.map(|at| (at as u32).min(last))) as usize];
        let size = f64::from(cell.size);
        let t = [0, 1].map(|axis| ((at[axis] - f64::from(cell.origin[axis])) / size).clamp(0.0, 1.0));
        patch.jet(t, size * self.step)
    }

    /// F and ∇F anywhere. Beyond the root it goes on as the octree's does: linear along the normal at first, far away with
    /// slope 1.
    pub fn value_and_gradient(&self, position: DVec2) -> (f64, DVec2) {
        let near = position.clamp(self.origin, self.origin + self.edge());
        let [value, by_y, by_x, by_xy] = self.jet(near);
        if near == position {
            return (value, DVec2::new(by_x, by_y));
        }
        let gone = position - near;
        let saturation = SATURATION * self.edge();
        let rate = saturation / (saturation + gone.abs());
        let length = gone * rate;
        let excess = gone - length;
        let slopes = DVec2::new(by_x + length.y * by_xy, by_y + length.x * by_xy);
        let value = value + length.x * by_x + length.y * by_y + length.x * length.y * by_xy - excess.length();
        (value, slopes * rate * rate - excess.normalize_or_zero() * (1.0 - rate * rate))
    }

    /// The hull of F over the part of a node, of some edge and place in smallest cells, between two places.
    fn range(&self, node: u32, cell: Cell, low: [f64; 2], high: [f64; 2]) -> Option<Interval> {
        let size = f64::from(cell.size);
        let part = |ends: [f64; 2]| [0, 1].map(|axis| (ends[axis] - f64::from(cell.origin[axis])) / size);
        let (low_in, high_in) = (part(low), part(high));
        if low_in.iter().any(|&t| t > 1.0) || high_in.iter().any(|&t| t < 0.0) {
            return None;
        }
        let what = self.nodes[node as usize];
        if what & LEAF != 0 {
            let [low, high] = [low_in, high_in].map(|t| t.map(|t| t.clamp(0.0, 1.0)));
            return Some(self.leaves[(what & !LEAF) as usize].1.range(low, high));
        }
        let children = (0..4).filter_map(|child| self.range(what + child, cell.child(child), low, high));
        children.reduce(Interval::union)
    }

    /// Bounds of F over a box, whatever its z; all numbers where it leaves the root.
    fn bounds(&self, region: &Aabb) -> Interval {
        let ends = [region.min, region.max].map(|corner| ((corner.truncate() - self.origin) / self.step).to_array());
        let size = f64::from(self.size);
        if ends.as_flattened().iter().any(|at| !(0.0..=size).contains(at)) {
            return Interval::ALL;
        }
        let root = Cell { origin: [0; 2], size: self.size };
        let Some(Interval { lo, hi }) = self.range(0, root, ends[0], ends[1]) else { return Interval::ALL };
        // Values are rounded to 32 bits, and points to those of their batch.
        let pad = 1e-6 * (lo.abs().max(hi.abs()) + self.step);
        Interval::new(lo - pad, hi + pad)
    }
}

/// A tree under construction.
struct Growing<'a, 'b> {
    cells: Vec<Cell>,
    /// The first of four children, or 0 for a leaf.
    children: Vec<u32>,
    samples: &'a mut Samples<'b>,
    settings: &'a Settings,
}

impl Growing<'_, '_> {
    /// Splits from the root down by the rules of the octree.
    fn refine(&mut self) -> Result<(), BuildError> {
        let mut active = vec![0_u32];
        while let Some(&first) = active.first() {
            let size = self.cells[first as usize].size;
            let cells: Vec<Cell> = active.iter().map(|&node| self.cells[node as usize]).collect();
            self.samples.request(&cells, |cell| cell.corners().map(in_space), |_| {})?;
            if size == 1 {
                break;
            }
            self.samples.request(&cells, |cell| cell.middles().map(in_space), |_| {})?;
            let split: Vec<u32> = active.into_iter().filter(|&node| self.splits(&self.cells[node as usize])).collect();
            active = Vec::with_capacity(4 * split.len());
            for node in split {
                let (first, cell) = (self.cells.len() as u32, self.cells[node as usize]);
                self.children[node as usize] = first;
                self.cells.extend((0..4).map(|child| cell.child(child)));
                self.children.extend([0; 4]);
                active.extend(first..first + 4);
            }
            // A node, a leaf with its patch, and its share of corners.
            let kept = size_of::<(Cell, Patch)>() + size_of::<Cell>() + 2 * size_of::<Jet>() + 64;
            let needed = self.samples.bytes() + self.cells.len() * kept;
            if needed > self.settings.memory_limit {
                return Err(BuildError::Memory { needed, limit: self.settings.memory_limit });
            }
        }
        Ok(())
    }

    /// Whether a cell whose corners and middles have samples is split.
    fn splits(&self, cell: &Cell) -> bool {
        let Settings { ratio, ratio_across, tolerance, tolerance_across, smallest_cell, .. } = *self.settings;
        let edge = f64::from(cell.size) * smallest_cell;
        let sample = |place: [u32; 2]| self.samples.get(in_space(place));
        let middles = cell.middles();
        let away = self.settings.beyond_levels(sample(middles[0]).value);
        let patch = lone_patch(cell.corners().map(sample), edge);
        let miss = |place: &[u32; 2]| {
            let ([value, by_y, by_x, _], truth) = (patch.jet(cell.within(*place), edge), sample(*place));
            let turn = DVec2::new(by_x, by_y).distance(DVec2::new(truth.gradient[0], truth.gradient[1]));
            (value - truth.value).abs().max(turn * edge * SLOPE_REACH)
        };
        if edge > ratio * away {
            (away <= 0.71 * edge && cell.size > LARGEST_AT_SURFACE)
                || middles.iter().map(miss).fold(0.0, f64::max) > tolerance
        } else {
            edge > ratio_across * away && self.is_around(cell) && miss(&middles[0]) > tolerance_across
        }
    }

    /// Whether some of a cell is no further from the region than that is large.
    fn is_around(&self, cell: &Cell) -> bool {
        let region = self.settings.region;
        let around = region.grown(region.size().max_element());
        let place = |corner: DVec3| self.samples.in_smallest_cells(corner).truncate();
        let origin = DVec2::new(f64::from(cell.origin[0]), f64::from(cell.origin[1]));
        origin.cmplt(place(around.max)).all() && (origin + f64::from(cell.size)).cmpgt(place(around.min)).all()
    }
}

/// A point of the plane as one of space.
fn in_space([x, y]: [u32; 2]) -> [u32; 3] {
    [x, y, 0]
}

/// The patch of a cell by itself: the mixed derivative is that of the gradients along its own edges.
fn lone_patch(corners: [&Sample; 4], edge: f64) -> Patch {
    let by = |corner: usize, axis: usize| corners[corner].gradient[axis];
    let jet = |corner: usize| {
        let along_x = (by(corner | 2, 1) - by(corner & 1, 1)) / edge;
        let along_y = (by(corner | 1, 0) - by(corner & 2, 0)) / edge;
        [corners[corner].value, by(corner, 1), by(corner, 0), 0.5 * (along_x + along_y)]
    };
    let jets: [Jet; 4] = std::array::from_fn(jet);
    Patch::hermite(jets.each_ref(), edge)
}

/// What lies beside a corner, by axis, below and above: the nearest other one, and how far that is in smallest cells.
type Beside = [[Option<(u32, u32)>; 2]; 2];

/// The corners of the leaves, numbered, and their jets as if none hung.
struct Jets {
    jets: Vec<Jet>,
    numbers: HashMap<[u32; 2], u32>,
}

impl Jets {
    fn new(leaves: &[Cell], samples: &Samples<'_>, step: f64) -> Self {
        let mut numbers = HashMap::new();
        let mut places = Vec::new();
        let mut beside: Vec<Beside> = Vec::new();
        for leaf in leaves {
            let own = leaf.corners().map(|place| {
                *numbers.entry(place).or_insert_with(|| {
                    places.push(place);
                    beside.push([[None; 2]; 2]);
                    places.len() as u32 - 1
                })
            });
            for (low, high, axis) in [(0, 2, 0), (1, 3, 0), (0, 1, 1), (2, 3, 1)] {
                for (corner, side, other) in [(own[low], 1, own[high]), (own[high], 0, own[low])] {
                    let known = &mut beside[corner as usize][axis][side];
                    if known.is_none_or(|(_, gap)| leaf.size < gap) {
                        *known = Some((other, leaf.size));
                    }
                }
            }
        }
        let sample = |corner: u32| samples.get(in_space(places[corner as usize]));
        // ∂/∂axis of the gradient's component.
        let along = |corner: u32, axis: usize, component: usize| {
            let own = sample(corner).gradient[component];
            let side = |side: Option<(u32, u32)>| {
                side.map(|(other, gap)| {
                    let gap = f64::from(gap) * step;
                    (gap, (sample(other).gradient[component] - own) / gap)
                })
            };
            let [below, above] = beside[corner as usize][axis].map(side);
            between(below, above)
        };
        let jet = |corner: u32| {
            let Sample { value, gradient: [by_x, by_y, _] } = *sample(corner);
            [value, by_y, by_x, 0.5 * (along(corner, 0, 1) + along(corner, 1, 0))]
        };
        Self { jets: (0..places.len() as u32).map(jet).collect(), numbers }
    }
}

impl Field for Quadtree {
    fn bounding_box(&self) -> Option<Aabb> {
        Some(self.shape)
    }

    fn jumps(&self) -> bool {
        self.restore == Restore::Linear
    }

    fn reference(&self, position: DVec3) -> f64 {
        self.value_and_gradient(position.truncate()).0
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(QuadtreeEvaluator { tree: self, regions: Vec::new() })
    }
}

impl Distance for Quadtree {
    /// Corners keep no points.
    fn closest_points(&self, _: &[DVec3], _: &mut [Foot]) -> bool {
        false
    }
}

struct QuadtreeEvaluator<'a> {
    tree: &'a Quadtree,
    regions: Vec<Aabb>,
}

impl Evaluator for QuadtreeEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.regions.push(*region);
    }

    fn bounds(&mut self) -> Interval {
        self.regions.last().map_or(Interval::ALL, |region| self.tree.bounds(region))
    }

    fn hints(&mut self, _: Hint) -> Hints {
        Hints { keeps_values: true, ..Hints::NONE }
    }

    fn leave(&mut self) {
        self.regions.pop();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        for (i, out) in out.iter_mut().enumerate().take(points.len) {
            *out = self.tree.value_and_gradient(points.position(i).truncate()).0 as f32;
        }
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        for i in 0..points.len {
            let (value, gradient) = self.tree.value_and_gradient(points.position(i).truncate());
            out.set(i, (value, gradient.extend(0.0)));
        }
    }
}
