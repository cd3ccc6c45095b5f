//! Distances far from the surface: a C¹ spline over a graded octree ([`DistanceObject`]).
//!
//! Corners of cells carry value and gradient of the signed distance, taken from closest points, and mixed
//! derivatives from differences; each cell is their tricubic Hermite patch; corners that hang on a coarser cell
//! take all from it. The space is that of PHT splines (polynomial splines over hierarchical T-meshes), which the
//! HFRep paper uses in 2D to restore a distance from an adaptively sampled one.
//!
//! **Guaranteed:** one C¹ function everywhere, positive inside, of the declared slope, bounded truly over boxes;
//! the same bits for any number of threads and any vector width. **Within tolerance:** its agreement with the
//! distance wherever cells are not the smallest. **Not guaranteed:** cells across the medial axis round it at the
//! size of the cell, which grows with the distance to the surface, to an eighth of it; smallest cells across a crease of
//! the surface round that.

pub(super) mod beyond;
mod bounds;
mod bricks;
pub(super) mod corners;
mod evaluate;
mod hanging;
mod kept;
mod kernel;
pub(super) mod patch;
pub(super) mod refine;
pub(super) mod samples;
mod steepest;
mod tree;

#[cfg(test)]
mod tests;

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use self::beyond::Border;
pub use self::bounds::Bounded;
use self::bricks::Bricks;
use self::corners::Numbers;
use self::evaluate::{OctreeEvaluator, Place};
use self::kernel::Polynomial;
use self::patch::{Jet, Patch};
use self::samples::Samples;
use self::tree::Tree;
use super::band;
use super::nearest::{ClosestPoint, Watch};
use super::{Distance, Foot};
use crate::field::{Aabb, Evaluator, Field, Interval, Slope};

/// Marks a node that is a leaf; the rest is the leaf's number.
const LEAF: u32 = 1 << 31;

/// The deepest octree: places of corners fit 21 bits an axis.
const DEEPEST: u32 = 20;

/// How often finished patches are looked at again. Each look costs about a tenth of the building and finds much less
/// than the one before.
const SECOND_LOOKS: usize = 3;

/// The share of all work that is done when cells have been split down to the smallest.
const REFINING: f64 = 0.6;
/// The same when all cells and corners are made.
const MADE: f64 = 0.95;

/// What a cell is between its corners.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Restore {
    /// The cubic Hermite patch: C¹ across all cells.
    #[default]
    Spline,
    /// Linear along each axis in the values at its own corners, as adaptively sampled distance fields began (Frisken et al.
    /// 2000; HFRep, Fig. 10a): slopes jump from cell to cell, and values where cells of different size meet.
    Linear,
}

/// What a cell takes, in bytes, beside its samples: while building, and what is kept of it.
pub(in crate::distance) const BYTES_A_CELL: usize =
    size_of::<tree::Cell>() + 9 * size_of::<u32>() + 40 + 3 * 64 + size_of::<Polynomial>();

/// How a [`DistanceObject`] is built.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Where distances are measured with certainty: cells grow with the way to it, too. It holds the surface; the root cell is
    /// a cube around it of at least four times its edge.
    /// Beyond the root the field goes on with the border's values and slopes.
    pub region: Aabb,
    /// The edge of the smallest cells, in world units: about a voxel. Corners of cells stand at integer multiples
    /// of it. Greater rounds creases more; half of it costs twice the cells on creases and four times on what is
    /// curved below a voxel.
    pub smallest_cell: f64,
    /// How far a patch may miss the distance before its cell is split, in world units.
    pub tolerance: f64,
    /// A cell smaller than this times its distance to the surface is not split, but across the medial axis. Smaller costs
    /// cells everywhere.
    pub ratio: f64,
    /// The same there, up to the region's longest side around it, where a cell misses the distance by up to 0.3 of its edge.
    /// Greater: what a morph makes of an object's inside has lumps on its ridges; smaller costs cells on all of the medial
    /// axis.
    pub ratio_across: f64,
    /// How far a cell between the two may miss the distance in its middle before it is taken to lie across the medial axis,
    /// in world units. More leaves lumps, less splits what is smooth.
    pub tolerance_across: f64,
    /// The distances whose level sets are asked for, positive inside: patches are right there in the region, and cells grow
    /// with the distance to them. 0 is the surface itself.
    pub levels: Interval,
    /// What cells are between their corners. Which cells there are does not depend on it.
    pub restore: Restore,
    /// The most memory, in bytes, that building may hold.
    pub memory_limit: usize,
}

impl Settings {
    /// The usual settings for a region and a smallest cell: a tolerance of a fiftieth of the cell, cells up to half
    /// their distance to the surface, across the medial axis up to an eighth where they miss it by a quarter of the
    /// smallest; 4 GiB.
    pub fn new(region: Aabb, smallest_cell: f64) -> Self {
        Self {
            region,
            smallest_cell,
            levels: Interval::ZERO,
            restore: Restore::Spline,
            tolerance: 0.02 * smallest_cell,
            ratio: 0.5,
            ratio_across: 0.125,
            tolerance_across: 0.25 * smallest_cell,
            memory_limit: 4 << 30,
        }
    }

    /// How far a distance is from those that are asked for.
    pub(super) fn beyond_levels(&self, distance: f64) -> f64 {
        (self.levels.lo - distance).max(distance - self.levels.hi).max(0.0)
    }
}

/// Why no distance object was built.
#[derive(Clone, Debug, PartialEq)]
pub enum BuildError {
    /// Stopped by [`Watch::cancel`].
    Cancelled,
    /// The region is empty or not finite, or the smallest cell is not a positive number.
    Settings,
    /// The region has more smallest cells along an edge than can be counted.
    TooFine {
        /// The least edge of the smallest cell that would do.
        smallest_cell: f64,
    },
    /// More memory than allowed.
    Memory {
        /// What was needed when it stopped, in bytes.
        needed: usize,
        /// What was allowed.
        limit: usize,
    },
    /// The distance or gradient at a point is not a finite number.
    NotFinite {
        /// Where.
        position: DVec3,
    },
    /// The field has no surface in the region.
    NoSurface,
    /// A shape of the plane, which this method does not measure.
    SolidsOnly {
        /// The method's name.
        method: &'static str,
    },
    /// What else may go wrong where the surface is sought.
    Surface(band::Error),
}

impl std::fmt::Display for BuildError {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Cancelled => write!(f, "stopped while measuring distances"),
            Self::Settings => write!(f, "distances need a finite, non-empty region and a smallest cell above 0"),
            Self::TooFine { smallest_cell } => {
                write!(f, "the smallest cell is too fine for the region: make it {smallest_cell:.3e} or larger")
            }
            Self::Memory { needed, limit } => write!(
                f,
                "measuring distances needs more than {} MiB, the limit is {} MiB: raise the limit, make the smallest cell \
                 (the voxel) larger, or take a smaller depth of `adf` where one is given",
                needed >> 20,
                limit >> 20
            ),
            Self::NotFinite { position } => write!(f, "the distance at {position} is not a finite number"),
            Self::Surface(error) => write!(f, "{error}"),
            Self::SolidsOnly { method } => write!(
                f,
                "`{method}` measures solids only: a shape of the plane is measured by `closest-point` or `adf`"
            ),
            Self::NoSurface => write!(f, "there is no surface in the region: F has one sign at every point tried"),
        }
    }
}

impl std::error::Error for BuildError {}

impl From<band::Error> for BuildError {
    fn from(error: band::Error) -> Self {
        match error {
            band::Error::Cancelled => Self::Cancelled,
            error => Self::Surface(error),
        }
    }
}

/// What was built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// Leaf cells.
    pub cells: usize,
    /// Corners of leaf cells.
    pub corners: usize,
    /// Those of them that hang on a coarser cell.
    pub hanging: usize,
    /// Closest points asked for.
    pub samples: usize,
    /// Halvings from the root to the smallest leaf.
    pub depth: u32,
    /// Bytes held by the object.
    pub bytes: usize,
    /// The greatest error at a sample nearer to the surface than a smallest cell, in world units.
    pub error_at_surface: f64,
    /// The greatest error at any sample, over its distance to the surface or a smallest cell if that is more.
    pub error_relative: f64,
}

/// The signed distance to a surface, everywhere, as a C¹ spline.
#[derive(Clone, Debug)]
pub struct DistanceObject {
    /// The root's least corner, in the world.
    origin: DVec3,
    /// The edge of a smallest cell.
    step: f64,
    inverse_step: f64,
    /// Halvings from the root to a smallest cell.
    depth: u32,
    /// The first of eight children, or [`LEAF`] and the leaf's number.
    nodes: Vec<u32>,
    /// By node.
    bounds: Vec<bounds::Stored>,
    /// By node: the most that |∇F| may be, less than what the bounds of the derivatives add up to. By themselves, since
    /// they are asked for far more often.
    slopes: Vec<f32>,
    leaves: Vec<[u32; 8]>,
    numbers: Vec<Numbers>,
    /// By leaf: what points are evaluated by.
    polynomials: Vec<Polynomial>,
    bricks: Bricks,
    border: Border,
    slope: f64,
    bounding_box: Option<Aabb>,
    restore: Restore,
    report: Report,
}

impl DistanceObject {
    /// Measures distances by closest points.
    pub fn build(oracle: &dyn ClosestPoint, settings: &Settings, watch: &Watch) -> Result<Self, BuildError> {
        let (origin, depth) = root(settings)?;
        let mut samples = Samples::new(oracle, watch, origin, settings.smallest_cell);
        let mut tree = Tree::new(1 << depth);
        let memory = |tree: &Tree, samples: &Samples| {
            // Beside the samples.
            let needed = samples.bytes() + tree.cells.len() * BYTES_A_CELL + Bricks::bytes_of(tree);
            if needed > settings.memory_limit {
                return Err(BuildError::Memory { needed, limit: settings.memory_limit });
            }
            Ok(())
        };
        refine::refine(&mut tree, &mut samples, settings, memory, watch)?;
        let edge = |cell: &tree::Cell| f64::from(cell.size) * settings.smallest_cell;
        let (mut nodes, mut order) = flatten(&tree);
        let mut made = corners::corners(&tree, &nodes, &order, &samples, settings.smallest_cell);
        for look in 0..SECOND_LOOKS {
            (watch.progress)(REFINING + (MADE - REFINING) * (look + 1) as f64 / (SECOND_LOOKS + 1) as f64);
            let patch = |leaf: usize, cell: &tree::Cell| made.patch(leaf, edge(cell));
            if !refine::refine_again(&mut tree, &order, patch, &mut samples, settings)? {
                break;
            }
            memory(&tree, &samples)?;
            (nodes, order) = flatten(&tree);
            // Given back first: as much again is made anew.
            drop(made);
            made = corners::corners(&tree, &nodes, &order, &samples, settings.smallest_cell);
        }
        if watch.cancelled() {
            return Err(BuildError::Cancelled);
        }
        (watch.progress)(MADE);
        if settings.restore == Restore::Linear {
            made.forget_hanging(&samples);
        }
        let smallest = order.iter().map(|&node| tree.cells[node as usize].size).min().unwrap_or(1);
        drop((tree, order));
        let mut object = Self {
            origin,
            step: settings.smallest_cell,
            inverse_step: 1.0 / settings.smallest_cell,
            depth,
            nodes,
            bounds: Vec::new(),
            slopes: Vec::new(),
            leaves: made.leaves,
            numbers: made.numbers,
            polynomials: Vec::new(),
            bricks: Bricks::default(),
            border: Border::default(),
            slope: 0.0,
            bounding_box: None,
            restore: settings.restore,
            report: Report {
                hanging: made.hanging,
                samples: samples.len(),
                depth: depth - smallest.trailing_zeros(),
                ..Report::default()
            },
        };
        object.measure(&samples);
        // What is kept takes the most memory: that of the samples is given back before.
        drop(samples);
        object.finish(settings.levels.contains(0.0));
        if settings.levels.contains(0.0) && (object.bounds[0].value().lo > 0.0 || object.bounds[0].value().hi < 0.0) {
            return Err(BuildError::NoSurface);
        }
        (watch.progress)(1.0);
        Ok(object)
    }

    /// Works out all that follows from nodes, leaves and numbers. `has_surface`: whether the surface itself was measured;
    /// else cells there are large, and nothing is known of it.
    fn finish(&mut self, has_surface: bool) {
        let places = self.leaf_places();
        self.polynomials = places.par_iter().map(|&place| Polynomial::of(&self.patch(place))).collect();
        self.bricks = Bricks::new(&self.nodes, self.root_size());
        self.bound(&places);
        self.report.bytes = self.bytes();
        if !has_surface {
            self.bounding_box = None;
        }
    }

    /// What was built.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// The cube that the octree fills.
    pub fn root_box(&self) -> Aabb {
        Aabb::new(self.origin, self.origin + f64::from(self.root_size()) * self.step)
    }

    fn root_size(&self) -> u32 {
        1 << self.depth
    }

    fn root(&self) -> Place {
        Place { node: 0, origin: [0; 3], size: self.root_size() as i32 }
    }

    fn holds(&self, position: DVec3) -> bool {
        let place = (position - self.origin) * self.inverse_step;
        place.cmpge(DVec3::ZERO).all() && place.cmple(DVec3::splat(f64::from(self.root_size()))).all()
    }

    /// The number of a leaf among the leaves.
    fn leaf(&self, place: Place) -> usize {
        (self.nodes[place.node as usize] & !LEAF) as usize
    }

    /// The patch of a leaf.
    fn patch(&self, place: Place) -> Patch {
        let corners = self.leaves[self.leaf(place)].map(|corner| corners::jet(&self.numbers[corner as usize]));
        let patch = Patch { corners, edge: f64::from(place.size) * self.step };
        match self.restore {
            Restore::Spline => patch,
            Restore::Linear => patch.linear(),
        }
    }

    /// The polynomial of a leaf.
    fn polynomial(&self, place: Place) -> &Polynomial {
        &self.polynomials[self.leaf(place)]
    }

    /// The leaf that holds a position of the root, and where in it.
    fn find(&self, position: DVec3) -> (Place, [f64; 3]) {
        let cell = self.smallest_cell(position);
        let mut place = self.root();
        while self.nodes[place.node as usize] & LEAF == 0 {
            place = place.child(self.nodes[place.node as usize], cell);
        }
        (place, self.within(place, position))
    }

    /// The smallest cell that holds a position of the root.
    fn smallest_cell(&self, position: DVec3) -> [i32; 3] {
        let last = self.root_size() as i32 - 1;
        ((position - self.origin) * self.inverse_step).to_array().map(|at| (at as i32).clamp(0, last))
    }

    /// Where in a leaf a position is, \[0, 1\] on each axis.
    fn within(&self, place: Place, position: DVec3) -> [f64; 3] {
        let at = ((position - self.origin) * self.inverse_step).to_array();
        let scale = 1.0 / f64::from(place.size);
        std::array::from_fn(|axis| ((at[axis] - f64::from(place.origin[axis])) * scale).clamp(0.0, 1.0))
    }

    /// F and its derivatives at a position of the root, in `f64`.
    fn jet(&self, position: DVec3) -> Jet {
        let (place, t) = self.find(position);
        self.patch(place).jet(t)
    }

    /// The same for one of many positions: `last` keeps the patch of the one before.
    fn jet_beside(&self, position: DVec3, last: &mut Option<(Place, Patch)>) -> Jet {
        let at = self.smallest_cell(position);
        let (place, patch) = match last {
            Some((place, patch)) if place.holds(at) => (*place, patch),
            _ => {
                let place = self.find(position).0;
                (place, &mut last.insert((place, self.patch(place))).1)
            }
        };
        patch.jet(self.within(place, position))
    }

    /// F and ∇F in `f64`.
    pub fn value_and_gradient(&self, position: DVec3) -> (f64, DVec3) {
        if !self.holds(position) {
            let [value, x, y, z] = self.beyond(position, &mut None);
            return (value, DVec3::new(x, y, z));
        }
        let jet = self.jet(position);
        (jet[0], DVec3::new(jet[4], jet[2], jet[1]))
    }

    fn measure(&mut self, samples: &Samples) {
        let errors = |(place, sample): ([u32; 3], &samples::Sample)| {
            let position = self.origin + DVec3::from(place.map(f64::from)) * self.step;
            let error = (self.jet(position)[0] - sample.value).abs();
            let distance = sample.value.abs();
            let at_surface = if distance <= self.step { error } else { 0.0 };
            (at_surface, error / distance.max(self.step))
        };
        let worst = |a: (f64, f64), b: (f64, f64)| (a.0.max(b.0), a.1.max(b.1));
        let (at_surface, relative) = samples.all().map(errors).reduce(|| (0.0, 0.0), worst);
        self.report.error_at_surface = at_surface;
        self.report.error_relative = relative;
        self.report.cells = self.leaves.len();
        self.report.corners = self.numbers.len();
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..])
            + size_of_val(&self.bounds[..])
            + size_of_val(&self.slopes[..])
            + size_of_val(&self.leaves[..])
            + size_of_val(&self.numbers[..])
            + size_of_val(&self.polynomials[..])
            + self.bricks.bytes()
    }
}

/// The root's least corner and depth.
pub(in crate::distance) fn root(settings: &Settings) -> Result<(DVec3, u32), BuildError> {
    let Settings { region, smallest_cell, tolerance, ratio, ratio_across, tolerance_across, .. } = *settings;
    let size = region.size();
    let good = |x: f64| x.is_finite() && x > 0.0;
    if !(region.min.is_finite() && good(size.max_element()) && size.min_element() >= 0.0) {
        return Err(BuildError::Settings);
    }
    if ![smallest_cell, tolerance, ratio, ratio_across, tolerance_across].into_iter().all(good) {
        return Err(BuildError::Settings);
    }
    // Four times the region: far cells are few, and what is measured is better than what is continued.
    let cells = 4.0 * (size.max_element() / smallest_cell).ceil();
    if cells > f64::from(1_u32 << DEEPEST) {
        return Err(BuildError::TooFine { smallest_cell: size.max_element() / f64::from((1 << (DEEPEST - 2)) - 1) });
    }
    let size = (cells as u32).next_power_of_two().max(2);
    let middle = (region.centre() / smallest_cell).round();
    Ok(((middle - f64::from(size / 2)) * smallest_cell, size.trailing_zeros()))
}

/// Nodes in depth-first order, so that what lies together is stored together, and the leaves among them in the same
/// order.
fn flatten(tree: &Tree) -> (Vec<u32>, Vec<u32>) {
    fn visit(tree: &Tree, from: u32, to: usize, nodes: &mut Vec<u32>, order: &mut Vec<u32>) {
        let children = tree.children[from as usize];
        if children == 0 {
            nodes[to] = LEAF | order.len() as u32;
            order.push(from);
            return;
        }
        let first = nodes.len();
        nodes[to] = first as u32;
        nodes.extend([0; 8]);
        for child in 0..8 {
            visit(tree, children + child, first + child as usize, nodes, order);
        }
    }
    let (mut nodes, mut order) = (vec![0], Vec::new());
    visit(tree, 0, 0, &mut nodes, &mut order);
    (nodes, order)
}

impl Field for DistanceObject {
    fn bounding_box(&self) -> Option<Aabb> {
        self.bounding_box
    }

    fn slope(&self) -> Slope {
        match self.restore {
            Restore::Spline => Slope::Lipschitz(self.slope),
            Restore::Linear => Slope::Unknown,
        }
    }

    fn jumps(&self) -> bool {
        self.restore == Restore::Linear
    }

    fn reference(&self, position: DVec3) -> f64 {
        self.value_and_gradient(position).0
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(OctreeEvaluator::new(self))
    }
}

impl Distance for DistanceObject {
    /// Values and gradients of those it was built from are kept, not the points.
    fn closest_points(&self, _: &[DVec3], _: &mut [Foot]) -> bool {
        false
    }
}
