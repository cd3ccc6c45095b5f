//! Space-time blending of shapes and space-time transfinite interpolation of attributes.
//!
//! [`Morph`] takes two objects and plans once how one becomes the other; from then on any scene time's field and
//! colour can be had by itself. Knows scene time τ (0 at a shot's first frame, 1 at its last), but no frames, no files
//! and no scene text.

mod both;
mod carry;
mod coarse;
mod common;
mod course;
mod curves;
mod delay;
mod delayed;
mod error;
mod extruded;
mod inertia;
mod mode;
mod motion;
mod object;
mod over_time;
mod pace;
mod partition;
mod plan;
mod plane;
mod real;
mod recent;
mod report;
mod section;
mod settings;
mod stb;
mod stti;
mod surfels;
mod turn;
mod velocity;
mod volume;

pub use carry::Untold;
pub use coarse::CoarseGrid;
pub use delay::Delay;
pub use error::{Error, Side};
pub use mode::linear::Linear;
pub use mode::paper::{Numbers, Paper};
pub use mode::still::Still;
pub use mode::union::Union;
pub use mode::volume::Volume;
pub use mode::{Mode, Pace};
pub use motion::{Motion, Moved, Similarity};
pub use object::MorphObject;
pub use over_time::OverTime;
pub use pace::Curve;
pub use plan::{Morph, Plan, Stage};
pub use plane::Plane;
pub use report::{FrameReport, Report};
pub use section::{Round, Section};
pub use settings::{Carry, Ease, Settings};
pub use stb::Stb;
pub use stti::{MorphAttribute, Transfer};
pub use velocity::{Around, Instant, Meter, Movement};

#[cfg(test)]
mod carry_tests;
#[cfg(test)]
mod delay_tests;
#[cfg(test)]
mod exact;
#[cfg(test)]
mod section_tests;
#[cfg(test)]
mod tests;
