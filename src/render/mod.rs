//! Pictures: ray casting of a coloured level set held in memory, slices through its inside, contact sheets and
//! animations of a sequence; PNG, APNG and EXR.
//!
//! [`render`] looks at a [`crate::grid::Band`] through a [`Camera`], [`render_layers`] takes the same view apart for
//! compositing, and a [`Slice`] shows its inside in a plane. A [`ContactSheet`] sets the pictures of a sequence in
//! rows, over the curves that tell whether a morph is sound; an [`Animation`] plays them. Nothing here computes a
//! distance or knows a file format but those of pictures.
//!
//! Geometry is seen as trilinear interpolation shows it: a ray meets the surface where the interpolated distance
//! is zero, found exactly in every cell (`trace`), so that no piece the samples hold is stepped over.

mod animation;
mod camera;
mod error;
mod exr_file;
mod field_slice;
mod ground;
mod image;
mod layers;
mod picture;
mod plot;
mod screen;
mod sheet;
mod slice;
mod slice_values;
mod studio;
mod text;
mod trace;
mod volume;

pub use animation::Animation;
pub use camera::{Camera, Up, View};
pub use error::{PictureError, save};
pub use field_slice::Shows;
pub use image::Image;
pub use layers::Layers;
pub use picture::{Lighting, Look, Quality, Scene, render, render_layers};
pub use sheet::{ContactSheet, SheetFrame};
pub use slice::{Fill, Plane, Slice};
pub use slice_values::{Numbers, SliceValues};
