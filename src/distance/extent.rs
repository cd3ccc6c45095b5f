//! Before any voxel: the box of the solid, and about how many blocks its band will take.

use std::fmt;

use glam::DVec3;
use rayon::prelude::*;

use crate::{
    field::{Aabb, Evaluator, Field, Hint},
    grid::{BLOCK_EDGE, BLOCK_VOXELS},
};

use super::descent::Scope;

/// Cells along the longest side when the box is searched. Larger finds tighter boxes of shapes that do not know
/// their own, in proportionally more time.
const CELLS: f64 = 512.0;
/// The same where a box is wanted soon.
const FEW_CELLS: f64 = 64.0;

/// Cells along the longest side in the first of the searches, each of which halves them.
const FIRST_CELLS: f64 = 8.0;

/// The most cells bounded for a side in one search. A side that would take more stays where the coarser search left it: one
/// that is flat along an axis has to be told from every cell beside it.
const BUDGET: usize = 16_384;

/// How far from the origin a box may reach, in world units: squares of it are finite in floats of 32 bits. Nested scales and
/// moves reach farther than each of them.
const FARTHEST: f64 = 1e18;

/// The box of a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Holds all of F ≥ 0 within the bounds that were given.
    pub solid: Aabb,
    /// Where the solid reaches the bounds given by the user and may be cut: least x, greatest x, least y, …
    pub reaches_bounds: [bool; 6],
}

/// Why there is no box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// The field may reach to infinity and no bounds were given.
    Unbounded,
    /// F < 0 everywhere.
    Empty,
    /// It reaches beyond what can be computed with.
    TooFar,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unbounded => "the shape may reach to infinity: give it `bounds`, or intersect it with a finite shape",
            Self::Empty => {
                "nothing is inside: the function is negative everywhere in its bounds; check the signs (positive is \
                 inside) and the bounds"
            }
            Self::TooFar => {
                "the shape reaches farther than can be computed: bring it nearer to the origin, or scale it down"
            }
        })
    }
}

impl std::error::Error for Error {}

/// The tight box of F ≥ 0, clipped to the user's `bounds` if there are any.
///
/// Found by bounds of F over cells of a grid whose step is a power of two near a 512th of the result, standing at
/// multiples of that step: so the result does not hang on how loose the field's own box or the bounds are. Flat sides that
/// neither of them tells may be a hundredth of the result outside.
pub fn extent(field: &dyn Field, bounds: Option<Aabb>) -> Result<Extent, Error> {
    of_cells(field, bounds, CELLS)
}

/// A box that holds it, in a fraction of the time: up to a 32nd of its longest side looser. What does not reach the bounds here
/// does not reach them.
pub fn about(field: &dyn Field, bounds: Option<Aabb>) -> Result<Extent, Error> {
    of_cells(field, bounds, FEW_CELLS)
}

fn of_cells(field: &dyn Field, bounds: Option<Aabb>, cells: f64) -> Result<Extent, Error> {
    let own = field.bounding_box();
    let within = match (own, bounds) {
        (Some(own), Some(bounds)) => own.intersection(bounds).ok_or(Error::Empty)?,
        (own, bounds) => own.or(bounds).ok_or(Error::Unbounded)?,
    };
    if !(within.min.is_finite() && within.max.is_finite()) {
        return Err(Error::Unbounded);
    }
    if within.min.abs().max(within.max.abs()).max_element() > FARTHEST {
        return Err(Error::TooFar);
    }
    let mut step = step_for(within, FIRST_CELLS);
    let mut open = [true; 6];
    let mut solid = search(field, within, step, &mut open)?;
    // A smaller box asks for a smaller step.
    while step > step_for(solid, cells) && open.contains(&true) {
        step /= 2.0;
        solid = search(field, solid, step, &mut open)?;
    }
    let reaches_bounds = std::array::from_fn(|side| {
        let axis = side / 2;
        bounds.is_some_and(|bounds| {
            if side % 2 == 0 { solid.min[axis] <= bounds.min[axis] } else { solid.max[axis] >= bounds.max[axis] }
        })
    });
    Ok(Extent { solid, reaches_bounds })
}

/// The power of two next below a share of a box's longest side.
fn step_for(within: Aabb, cells: f64) -> f64 {
    libm::exp2(libm::floor(libm::log2(within.size().max_element() / cells)))
}

/// Shrinks the `open` sides of a box around F ≥ 0, on the grid of multiples of `step`, and closes those that would take too
/// long.
fn search(field: &dyn Field, within: Aabb, step: f64, open: &mut [bool; 6]) -> Result<Aabb, Error> {
    if step <= 0.0 {
        *open = [false; 6];
        return Ok(within);
    }
    // The root: the least cube of 2ⁿ steps, at a multiple of the step, that holds the box.
    let first = (within.min / step).floor() * step;
    let mut edge = step;
    while (first + edge).cmplt(within.max).any() {
        edge *= 2.0;
    }
    let reached = |side: usize| {
        let (axis, least) = (side / 2, side.is_multiple_of(2));
        let mut walk = Extreme { evaluator: field.evaluator(), within, step, axis, least, best: None, budget: BUDGET };
        walk.visit(first, edge);
        walk
    };
    // Each side takes the same cells whatever the others find.
    let sides: Vec<usize> = (0..6).filter(|side| open[*side]).collect();
    let walks: Vec<(usize, Extreme<'_>)> = sides.into_par_iter().map(|side| (side, reached(side))).collect();
    let mut found = within;
    for (side, walk) in walks {
        open[side] = walk.budget > 0;
        if open[side] {
            let best = walk.best.ok_or(Error::Empty)?;
            let axis = side / 2;
            if walk.least {
                found.min[axis] = best.max(within.min[axis]);
            } else {
                found.max[axis] = best.min(within.max[axis]);
            }
        }
    }
    Ok(found)
}

/// Depth-first search for the least or greatest coordinate of F ≥ 0 along one axis, the most promising half first.
struct Extreme<'a> {
    evaluator: Box<dyn Evaluator + 'a>,
    within: Aabb,
    step: f64,
    axis: usize,
    least: bool,
    best: Option<f64>,
    /// Cells that may yet be bounded. At 0 the search is given up.
    budget: usize,
}

impl Extreme<'_> {
    fn visit(&mut self, origin: DVec3, edge: f64) {
        let Some(cell) = Aabb::new(origin, origin + edge).intersection(self.within) else { return };
        let promise = if self.least { cell.min[self.axis] } else { cell.max[self.axis] };
        if self.budget == 0 || self.best.is_some_and(|best| if self.least { promise >= best } else { promise <= best })
        {
            return;
        }
        self.evaluator.enter(&cell);
        let bounds = self.evaluator.bounds();
        self.budget -= 1;
        if bounds.lo >= 0.0 || (bounds.hi >= 0.0 && edge <= self.step) {
            self.best = Some(promise);
        } else if bounds.hi >= 0.0 {
            let half = edge / 2.0;
            for near in [self.least, !self.least] {
                for child in 0..4 {
                    let mut corner = origin;
                    corner[self.axis] += if near { 0.0 } else { half };
                    corner[(self.axis + 1) % 3] += f64::from(child >> 1) * half;
                    corner[(self.axis + 2) % 3] += f64::from(child & 1) * half;
                    self.visit(corner, half);
                }
            }
        }
        self.evaluator.leave();
    }
}

/// What a band will take, about: rather too much than too little.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// Leaf blocks that will be evaluated.
    pub blocks: f64,
    /// Active voxels.
    pub voxels: f64,
    /// Bytes of one float grid over the blocks.
    pub bytes: f64,
}

/// What the allocator takes for lists of active voxels' values, in parts of what they hold.
const LIST_OVERHEAD: f64 = 1.2;

impl Estimate {
    /// Bytes of the file before compression: a level set, and so many numbers a voxel in other grids (a colour: 3).
    pub fn file(&self, numbers: usize) -> f64 {
        self.voxels * 4.0 * (1 + numbers) as f64
    }

    /// Bytes that so many frames take at a job's peak: all are whole, one is being written.
    pub fn memory(&self, numbers: usize, frames: usize) -> f64 {
        let others = self.voxels * 4.0 * numbers as f64 * LIST_OVERHEAD;
        // The encoded file is held whole; hardly ever larger than the voxels.
        frames as f64 * (self.bytes + others) + self.file(numbers)
    }
}

/// Boxes bounded at most for an estimate; more is more exact, and slower.
const ESTIMATE_BUDGET: usize = 60_000;

/// Boxes that one evaluator is made for, at least.
const BOXES_A_TASK: usize = 16;

/// How much work goes into an estimate: the boxes found on the surface that are enough for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// Good to some tens of per cent, rather too much than too little.
    Quick,
    /// Good to some per cent.
    Careful,
}

impl Effort {
    fn enough(self) -> usize {
        match self {
            Self::Quick => 400,
            Self::Careful => 4_000,
        }
    }
}

/// Estimates a band before anything is allocated, in well under a second for any voxel size: a descent of the region
/// to boxes that are few, scaled by area to blocks.
///
/// A plane meets, in the mean over its directions, A·1.5·(e − 1 + 2w)/e³ nodes of e³ voxels grown by w, with its
/// area A in voxel faces; that gives A from the boxes found and the blocks from A.
pub fn estimate(field: &dyn Field, scope: &Scope, effort: Effort) -> Estimate {
    BandBoxes::find(field, scope, effort).estimate(scope)
}

/// Boxes that may hold a piece of the band, small enough to be many.
pub struct BandBoxes {
    corners: Vec<DVec3>,
    edge: f64,
}

impl BandBoxes {
    /// Descends the region until there are enough.
    pub fn find(field: &dyn Field, scope: &Scope, effort: Effort) -> Self {
        let voxel = scope.lattice.voxel_size.get();
        let longest = scope.region.size().max_element().max(voxel);
        let (mut edge, mut corners) = (longest, vec![scope.region.min]);
        let mut bounded = 0;
        while !corners.is_empty() && corners.len() < effort.enough() && edge >= f64::from(BLOCK_EDGE) * voxel {
            bounded += 8 * corners.len();
            if bounded > ESTIMATE_BUDGET {
                break;
            }
            corners = halves_at_band(field, scope, &corners, edge);
            edge /= 2.0;
        }
        Self { corners, edge }
    }

    /// See [`estimate`].
    pub fn estimate(&self, scope: &Scope) -> Estimate {
        let (width, block) = (2.0 * f64::from(scope.half_width), f64::from(BLOCK_EDGE));
        let thickness = |edge: f64| 1.5 * (edge - 1.0 + width);
        let nodes = self.edge / scope.lattice.voxel_size.get();
        let area = self.corners.len() as f64 * nodes.powi(3) / thickness(nodes.max(1.0));
        // What the scaling takes too low for the shape's curvature, and what the descent opens in vain.
        let blocks = area * thickness(block) / block.powi(3) * 1.25;
        let bytes_a_block = (BLOCK_VOXELS * 4 + 64 + 12) as f64;
        Estimate { blocks, voxels: area * width, bytes: blocks * bytes_a_block }
    }

    /// The middles of at most so many, evenly chosen.
    pub fn middles(&self, most: usize) -> impl Iterator<Item = DVec3> {
        let stride = self.corners.len().div_ceil(most).max(1);
        self.corners.iter().step_by(stride).map(|corner| corner + 0.5 * self.edge)
    }
}

/// The least corners of those halves of boxes of one edge that may hold a piece of the band.
fn halves_at_band(field: &dyn Field, scope: &Scope, boxes: &[DVec3], edge: f64) -> Vec<DVec3> {
    let margin = f64::from(scope.half_width) * scope.lattice.voxel_size.get();
    let half = edge / 2.0;
    let of_box = |evaluator: &mut Box<dyn Evaluator + '_>, &origin: &DVec3| {
        let mut found = Vec::new();
        evaluator.enter(&Aabb::new(origin, origin + edge).grown(margin));
        for corner in Aabb::new(origin, origin + half).corners() {
            let Some(cell) = Aabb::new(corner, corner + half).intersection(scope.region) else { continue };
            evaluator.enter(&cell.grown(margin));
            if evaluator.hints(Hint::Vanishes).vanishes || evaluator.bounds().contains(0.0) {
                found.push(corner);
            }
            evaluator.leave();
        }
        evaluator.leave();
        found
    };
    boxes.par_iter().with_min_len(BOXES_A_TASK).map_init(|| field.evaluator(), of_box).flatten_iter().collect()
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::{
        distance::{
            descent::descend,
            testing::{Joined, Leaf},
        },
        grid::{Lattice, VoxelSize},
    };

    #[test]
    fn a_loose_box_shrinks_to_the_shape_and_does_not_show() {
        let mut field = Joined::one(Leaf::Sphere(DVec3::new(0.3, 0.0, 0.0), 1.0));
        let mut results = Vec::new();
        for (least, greatest) in [(-1.9, 1.7), (-50.0, 80.0), (-3.0, 1.5)] {
            field.bounds = Aabb::new(DVec3::splat(least), DVec3::splat(greatest));
            results.push(extent(&field, None).unwrap().solid);
        }
        for solid in &results {
            assert_eq!(*solid, results[0]);
            for (got, truth) in [(solid.min, DVec3::new(-0.7, -1.0, -1.0)), (solid.max, DVec3::new(1.3, 1.0, 1.0))] {
                assert!((got - truth).abs().max_element() < 0.01, "{got}");
            }
            assert!(solid.min.cmple(DVec3::new(-0.7, -1.0, -1.0)).all());
            assert!(solid.max.cmpge(DVec3::new(1.3, 1.0, 1.0)).all());
        }
    }

    #[test]
    fn bounds_clip_and_say_so() {
        let field = Joined::one(Leaf::Sphere(DVec3::ZERO, 1.0));
        let bounds = Aabb::new(DVec3::new(-2.0, -2.0, -0.5), DVec3::splat(2.0));
        let extent = extent(&field, Some(bounds)).unwrap();
        assert_eq!(extent.reaches_bounds, [false, false, false, false, true, false]);
        assert_eq!(extent.solid, Aabb::new(DVec3::new(-1.0, -1.0, -0.5), DVec3::splat(1.0)));
    }

    #[test]
    fn nothing_and_infinity_are_errors() {
        let field = Joined::one(Leaf::Sphere(DVec3::ZERO, 1.0));
        let beside = Aabb::new(DVec3::splat(0.9), DVec3::splat(1.0));
        assert_eq!(extent(&field, Some(beside)), Err(Error::Empty));
        let mut endless = field.clone();
        endless.bounds.max = DVec3::INFINITY;
        assert_eq!(extent(&endless, None), Err(Error::Unbounded));
    }

    #[test]
    fn estimates_hold_what_a_descent_opens() {
        let x = DVec3::new(0.4, 0.0, 0.0);
        let fields = [
            Joined::one(Leaf::Sphere(DVec3::ZERO, 1.0)),
            Joined::one(Leaf::Torus(0.8, 0.15)),
            Joined::union(vec![Leaf::Sphere(x, 0.7), Leaf::Sphere(-x, 0.7)]),
            Joined::oriented_box(glam::DMat3::IDENTITY, DVec3::new(0.9, 0.5, 0.1)),
        ];
        for field in fields {
            for size in [0.2, 0.05, 1.0 / 64.0, 1.0 / 200.0] {
                let lattice = Lattice { voxel_size: VoxelSize::new(size).unwrap() };
                let region = field.bounds.grown(4.0 * size);
                let scope = Scope { lattice, half_width: 3.0, region };
                let opened = descend(&field, &scope, &AtomicBool::new(false)).unwrap().blocks.len() as f64;
                for (effort, most) in [(Effort::Careful, 3.0), (Effort::Quick, 3.0)] {
                    let ratio = estimate(&field, &scope, effort).blocks / opened;
                    assert!((0.95..most).contains(&ratio), "{ratio} at {size} of {field:?}, {effort:?}");
                }
            }
        }
    }

    #[test]
    fn absurd_voxels_are_estimated_at_once() {
        let field = Joined::one(Leaf::Sphere(DVec3::ZERO, 1.0));
        let lattice = Lattice { voxel_size: VoxelSize::new(1e-9).unwrap() };
        let scope = Scope { lattice, half_width: 3.0, region: field.bounds };
        let voxels = estimate(&field, &scope, Effort::Careful).voxels;
        let truth = 4.0 * std::f64::consts::PI * 6.0 * 1e18;
        assert!((0.9..1.5).contains(&(voxels / truth)), "{}", voxels / truth);
    }
}
