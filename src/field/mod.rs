//! Function representation: anything that answers F at any point, positive inside.
//!
//! [`Field`] is what the rest of the crate builds on: batches of up to 512 points, bounds over boxes that prune,
//! gradients, and the smooth branches that meet at creases. Expressions implement it here; distance objects,
//! meshes and morphs implement it in their own rooms.

mod balls;
mod batch;
mod bent;
mod bounds;
mod branch;
mod candidates;
pub mod cells;
mod combine;
mod copies;
mod darts;
mod distances;
mod drawing;
mod eigen;
mod ellipsoid;
mod expression;
mod extent;
pub mod facet;
mod facts;
mod formula;
mod graph;
mod heights;
mod interval;
mod kernel;
mod kernel_gradient;
pub(crate) mod lane_math;
mod leaf;
mod machine;
mod noise;
mod op;
mod open_foam;
mod outline;
mod part;
mod part_tree;
mod parts;
mod place;
mod polygon;
mod program;
mod prune;
mod rows;
mod seeds;
mod silhouette;
mod solids;
mod spine;
mod struts;
mod tape;
#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
pub(crate) mod tests;
mod voronoi;
mod walls;
mod width;

pub use balls::Balls;
pub use batch::{BATCH, Gradients, Points};
pub(crate) use batch::{greater, lesser};
pub use bent::{Bent, Folded};
pub use combine::{Blend, BlendBounds, Kernel, SetSystem};
pub use copies::{Copies, CopyPlace};
pub use darts::{Dart, DartError, Darts, WIDEST, shares_at};
pub use distances::Side;
pub use drawing::{Drawing, Fill, outline};
pub(crate) use eigen::{eigen, eigen_descending};
pub use ellipsoid::{Ellipse, Ellipsoid};
pub use expression::{Expression, ExpressionEvaluator};
pub use formula::{Formula, FormulaError, Names, functions};
pub use graph::{Graph, Node};
pub use heights::Heights;
pub use interval::{Aabb, Interval};
pub use noise::{Fold, Fractal, GradientNoise, Near, Noise, NoiseField, Simplex, ValueNoise, Worley};
pub use open_foam::{OpenFoam, edges_of};
pub use outline::Outline;
pub use part::{Parts, Sample};
pub use parts::{Joined, Procedure};
pub use place::{NotInvertible, rotation, rotation_about};
pub use seeds::Seeds;
pub use spine::Spine;
pub use struts::{Strut, Struts};
pub use walls::Walls;
pub use width::VectorWidth;

use glam::DVec3;

/// What a field's value says about the distance to its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Slope {
    /// The value is the signed distance, outside and inside as flagged; |∇F| = 1 and |F| never exceeds the
    /// distance on the side that is not exact.
    Exact {
        /// Exact where F < 0.
        outside: bool,
        /// Exact where F > 0.
        inside: bool,
    },
    /// |F(p) − F(q)| ≤ L·|p − q|.
    Lipschitz(f64),
    /// Nothing is declared.
    Unknown,
}

/// A scalar function of space, positive inside the solid, in world units.
pub trait Field: Send + Sync {
    /// A box outside of which F < 0, or `None` where the solid may reach to infinity.
    fn bounding_box(&self) -> Option<Aabb>;

    /// What the value says about distance.
    fn slope(&self) -> Slope {
        Slope::Unknown
    }

    /// Whether F may jump from one value to another, of which its gradient tells nothing.
    fn jumps(&self) -> bool {
        false
    }

    /// F in plain `f64` arithmetic: slow, obvious, the judge of every faster way.
    fn reference(&self, position: DVec3) -> f64;

    /// An evaluator for one thread, with its own scratch memory. Make one a task, not one a block.
    fn evaluator(&self) -> Box<dyn Evaluator + '_>;
}

/// What evaluators may know beyond what each must answer: it saves time, and changes no voxel. `false` and `None` tell
/// nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hints {
    /// Whether regions leave every value as it is, to the last bit: nothing is pruned, what is known of a region only finds
    /// values faster.
    pub keeps_values: bool,
    /// Whether F has so many parts that regions are best entered on the way to small ones within.
    pub has_many_parts: bool,
    /// Whether F is known to be zero somewhere in the innermost region entered, for less than bounds take: then those
    /// need not be asked for.
    pub vanishes: bool,
    /// The most that |∇F| may be in the innermost region entered. A morph of two fields that answer opens fewer blocks: a
    /// value then tells how far away its surface is at least.
    pub steepest: Option<f64>,
}

impl Hints {
    /// Nothing is known.
    pub const NONE: Self = Self { keeps_values: false, has_many_parts: false, vanishes: false, steepest: None };
}

/// Which of the [`Hints`] is asked for: others that take time to find may be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the fields of `Hints`")]
pub enum Hint {
    KeepsValues,
    HasManyParts,
    Vanishes,
    Steepest,
}

/// Evaluates one field on one thread. Regions nest: everything evaluated between [`Evaluator::enter`] and the
/// matching [`Evaluator::leave`] must lie in the region entered.
pub trait Evaluator: Send {
    /// Prunes for all calls until the matching `leave`.
    ///
    /// Pruning keeps the zero set, the sign, and value and gradient *on* the zero set (of operations of R_m the gradient's
    /// direction); F away from the surface may change (an operand that cannot matter for the sign is dropped).
    fn enter(&mut self, region: &Aabb);

    /// Bounds of F over the innermost region entered, rounded outward: of the unpruned F or tighter in sign; they
    /// never miss a zero.
    fn bounds(&mut self) -> Interval;

    /// Leaves the innermost region.
    fn leave(&mut self);

    /// F at each point. Entries of `out` past `points.len` are unspecified.
    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]);

    /// F and its gradient at each point. Where F has no gradient (a crease) one of the sides' is given.
    fn gradients(&mut self, points: &Points, out: &mut Gradients);

    /// What else is known, of which the one asked for is worked out. A wrapper starts from all hints of the field that it
    /// wraps.
    fn hints(&mut self, asked: Hint) -> Hints;

    /// The number of smooth branches that remain in the region: the operands, below all set operations, whose
    /// zero sets together contain the zero set of F. At least 1; 1 means that F is itself smooth here (or is
    /// to be treated so).
    fn branches(&self) -> usize {
        1
    }

    /// Value and gradient of one branch (0 ≤ `branch` < [`Evaluator::branches`]).
    fn branch(&mut self, branch: usize, points: &Points, out: &mut Gradients) {
        debug_assert_eq!(branch, 0);
        self.gradients(points, out);
    }
}
