//! Colour and other attributes at points in space: sources, colour spaces, rules for set operations.
//!
//! An attribute is N numbers at every point: a colour three, scene-linear Rec.709, a scalar one. Where a source or a
//! rule is the same for all of them it is written once, for any N. What stands elsewhere, or moves, is seen through a
//! [`SpaceMap`].

mod affine;
mod ball_colour;
mod bands;
mod cells;
mod colour_space;
pub mod conformal;
mod constant;
mod conversion;
mod diffusion;
mod formula;
mod mapped;
mod mesh_colour;
mod mesh_number;
mod mix;
mod parts;
mod positional;
mod primaries;
mod ramp;
mod scalar_field;
mod surface;
mod travel;
mod voxels;

pub use affine::AffineVector;
pub use ball_colour::BallColours;
pub use bands::Bands;
pub use cells::{ByCell, CellIndex, Choice, CubeLattice};
pub use colour_space::{ColourSpace, LUMINANCE, from_srgb, to_srgb};
pub use constant::Constant;
pub use diffusion::{Diffusion, DiffusionError, Spreading};
pub use formula::{ByFormula, Components, FieldValue};
pub use mapped::{MappedSampler, SpaceMap};
pub use mesh_colour::{Below, MeshColours};
pub use mesh_number::MeshNumbers;
pub use mix::{Mix, Mixer, Straight, Turn};
pub use parts::{Overlap, Part, Parts, Rule};
pub use primaries::Primaries;
pub use ramp::{Ramp, RampEase};
pub use scalar_field::ScalarField;
pub use surface::{Curvature, Facing};
pub use travel::{Journey, Sources, Travel, TravelError};
pub use voxels::{Outside, POWERS, Power, RELATIVE_ERROR, ValueBlocks, VoxelValues};

use crate::field::{Aabb, BATCH, Gradients, Interval, Points};

/// Scene-linear Rec.709 red, green, blue.
pub type LinearRgb = [f32; 3];

/// A colour at every point of space, scene-linear Rec.709.
pub type Colour = dyn Attribute<3>;

/// A number at every point of space.
pub type Scalar = dyn Attribute<1>;

/// `N` numbers at every point of space.
pub trait Attribute<const N: usize>: Send + Sync {
    /// A sampler for one thread, with its own scratch memory.
    fn sampler(&self) -> Box<dyn Sampler<N> + '_>;
}

/// Bounds of each number of some values, of which there is at least one.
fn around<const N: usize>(values: impl Iterator<Item = [f32; N]>) -> [Interval; N] {
    let single = |value: f32| Interval::new(value.into(), value.into());
    let both = |a: [Interval; N], b: [Interval; N]| std::array::from_fn(|i| a[i].union(b[i]));
    values.map(|value| value.map(single)).reduce(both).unwrap_or([Interval::ALL; N])
}

/// Samples one attribute on one thread. Regions nest as in [`crate::field::Evaluator`].
pub trait Sampler<const N: usize>: Send {
    /// All points sampled until the matching `leave` lie in the region.
    fn enter(&mut self, region: &Aabb);
    /// Leaves the innermost region.
    fn leave(&mut self);
    /// The numbers at each point.
    fn sample(&mut self, points: &Points, out: &mut [[f32; N]; BATCH]);
    /// Each number with its gradient at each point; false, and nothing of use in `out`, where it has none of its own and
    /// differences of samples must do.
    fn gradients(&mut self, _points: &Points, _out: &mut [Gradients; N]) -> bool {
        false
    }
    /// Bounds of each number over a region, whatever regions were entered; [`Interval::ALL`] where they are not known.
    fn bounds(&mut self, _region: &Aabb) -> [Interval; N] {
        [Interval::ALL; N]
    }
}
