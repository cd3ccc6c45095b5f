//! A picture in the terminal: in its own pixels where it can (kitty, iTerm, sixel), else in half blocks.

use image::{DynamicImage, RgbaImage};
use viuer::Config;

use crate::cli::failure::Failure;
use crate::render::Image;

/// Shows a picture below the cursor.
pub fn show(image: &Image) -> Result<(), Failure> {
    let pixels = image.pixels().as_flattened().to_vec();
    let size = [image.width(), image.height()].map(|edge| u32::try_from(edge).unwrap_or(u32::MAX));
    let picture = RgbaImage::from_raw(size[0], size[1], pixels).map(DynamicImage::ImageRgba8);
    let picture = picture.ok_or_else(|| Failure::work("the picture is too large for a terminal"))?;
    let config = Config { absolute_offset: false, ..Config::default() };
    match viuer::print(&picture, &config) {
        Ok(_) => Ok(()),
        // A reader that went away (`| head`) is no failure.
        Err(viuer::ViuError::Io(error)) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        Err(error) => Err(Failure::work(format!("the terminal cannot show the picture: {error}; use -o picture.png"))),
    }
}
