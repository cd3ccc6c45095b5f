//! Pictures: ray casting of a coloured level set held in memory, contact sheets of a sequence, PNG.
//!
//! [`render`] looks at a [`crate::grid::Band`] through a [`Camera`]; a [`ContactSheet`] sets the pictures of a
//! sequence in rows, over the curves that tell whether a morph is sound. Nothing here computes a distance or knows a
//! file format but PNG.
//!
//! Geometry is seen as trilinear interpolation shows it: a ray meets the surface where the interpolated distance
//! is zero, found exactly in every cell (`trace`), so that no piece the samples hold is stepped over.

mod camera;
mod image;
mod picture;
mod plot;
mod screen;
mod sheet;
mod studio;
mod text;
mod trace;
mod volume;

pub use camera::{Camera, View};
pub use image::{Image, PictureError};
pub use picture::{Lighting, Look, Scene, render};
pub use sheet::{ContactSheet, SheetFrame};
