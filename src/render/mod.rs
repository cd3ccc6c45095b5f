//! Pictures: ray casting of a coloured level set held in memory, PNG.
//!
//! [`render`] looks at a [`crate::grid::Band`] through a [`Camera`]. Nothing here computes a distance or knows a
//! file format but PNG.
//!
//! Geometry is seen as trilinear interpolation shows it: a ray meets the surface where the interpolated distance
//! is zero, found exactly in every cell (`trace`), so that no piece the samples hold is stepped over.

mod camera;
mod image;
mod picture;
mod studio;
mod trace;
mod volume;

pub use camera::{Camera, View};
pub use image::{Image, PictureError};
pub use picture::{Lighting, Look, Scene, render};
