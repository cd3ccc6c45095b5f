//! Colour and other attributes at points in space: sources, colour spaces, rules for set operations.
//!
//! Everything here answers in scene-linear Rec.709. What stands elsewhere, or moves, is seen through a [`SpaceMap`].

mod bands;
mod cells;
mod colour_space;
mod constant;
mod conversion;
mod formula;
mod mapped;
mod mesh_colour;
mod mix;
mod parts;

pub use bands::Bands;
pub use cells::{ByCell, CellIndex, Choice, CubeLattice};
pub use colour_space::{ColourSpace, from_srgb, to_srgb};
pub use constant::Constant;
pub use formula::{ByFormula, Components};
pub use mapped::{MappedSampler, SpaceMap};
pub use mesh_colour::VertexColours;
pub use mix::{Mixer, Turn};
pub use parts::{Part, Parts, Rule};

use crate::field::{Aabb, BATCH, Points};

/// Scene-linear Rec.709 red, green, blue.
pub type LinearRgb = [f32; 3];

/// A colour at every point of space.
pub trait Colour: Send + Sync {
    /// A sampler for one thread, with its own scratch memory.
    fn sampler(&self) -> Box<dyn ColourSampler + '_>;
}

/// Samples one colour on one thread. Regions nest as in [`crate::field::Evaluator`].
pub trait ColourSampler {
    /// All points sampled until the matching `leave` lie in the region.
    fn enter(&mut self, region: &Aabb);
    /// Leaves the innermost region.
    fn leave(&mut self);
    /// The colour at each point, scene-linear Rec.709.
    fn sample(&mut self, points: &Points, out: &mut [LinearRgb; BATCH]);
}
