//! An image of 8-bit sRGB pixels, and its PNG.

use std::sync::LazyLock;

use super::error::{PictureError, png_size};

/// Rows of sRGB-encoded red, green, blue and (straight) alpha, the top row first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 4]>,
}

impl Image {
    /// An image of one colour.
    pub fn new(width: usize, height: usize, colour: [u8; 4]) -> Self {
        Self { width, height, pixels: vec![colour; width * height] }
    }

    /// Pixels across.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Pixels down.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All pixels, row by row from the top left.
    pub fn pixels(&self) -> &[[u8; 4]] {
        &self.pixels
    }

    /// All pixels, to be changed.
    pub fn pixels_mut(&mut self) -> &mut [[u8; 4]] {
        &mut self.pixels
    }

    /// The pixel at a column and row, which must lie in the image.
    pub fn pixel(&self, column: usize, row: usize) -> [u8; 4] {
        self.pixels[row * self.width + column]
    }

    /// Copies another image in with its top left corner at a column and row; what falls outside is left out.
    pub fn paste(&mut self, other: &Self, column: usize, row: usize) {
        let across = other.width.min(self.width.saturating_sub(column));
        let down = other.height.min(self.height.saturating_sub(row));
        for line in 0..down {
            let from = &other.pixels[line * other.width..][..across];
            self.pixels[(row + line) * self.width + column..][..across].copy_from_slice(from);
        }
    }

    /// Lays a colour over one pixel with a weight from 0 to 1; a place outside the image is left out. The mix is
    /// of encoded values, which is what makes thin lines and letters look evenly heavy.
    pub fn cover(&mut self, column: i64, row: i64, colour: [u8; 3], weight: f32) {
        let (Ok(column), Ok(row)) = (usize::try_from(column), usize::try_from(row)) else { return };
        if column >= self.width || row >= self.height {
            return;
        }
        let pixel = &mut self.pixels[row * self.width + column];
        for (below, above) in pixel.iter_mut().zip(colour) {
            let mixed = f32::from(*below) + (f32::from(above) - f32::from(*below)) * weight.clamp(0.0, 1.0);
            *below = (mixed + 0.5) as u8;
        }
    }

    /// The image as the bytes of a PNG file, marked as sRGB.
    pub fn encode_png(&self) -> Result<Vec<u8>, PictureError> {
        let (width, height) = png_size(self.width, self.height)?;
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        // Pictures are looked at and thrown away: a fifth larger, and stored in a tenth of the time.
        encoder.set_compression(png::Compression::Fast);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        writer.finish()?;
        Ok(bytes)
    }
}

/// One linear value, 0 to 1, as an 8-bit sRGB value (IEC 61966-2-1).
pub(super) fn encode_srgb(linear: f32) -> u8 {
    /// The least linear value of each byte but 0.
    static LEAST: LazyLock<[f64; 255]> =
        LazyLock::new(|| std::array::from_fn(|byte| linear_of((byte as f64 + 0.5) / 255.0)));
    // No comparison with NaN holds, and so it becomes 0.
    LEAST.partition_point(|least| *least <= f64::from(linear)) as u8
}

/// An 8-bit sRGB value as a linear one.
pub(super) fn decode_srgb(encoded: u8) -> f32 {
    linear_of(f64::from(encoded) / 255.0) as f32
}

fn linear_of(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{super::error::save, *};

    #[test]
    fn every_srgb_byte_survives_decoding_and_encoding() {
        for byte in 0..=255 {
            assert_eq!(encode_srgb(decode_srgb(byte)), byte);
        }
        assert_eq!(encode_srgb(f32::NAN), 0);
        assert_eq!(encode_srgb(0.5), 188); // The known mid-point of the curve.
    }

    #[test]
    fn a_png_reads_back_as_it_was() {
        let mut image = Image::new(3, 2, [10, 20, 30, 255]);
        image.pixels_mut()[4] = [255, 0, 127, 255];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        save(&path, &image.encode_png().unwrap()).unwrap();
        let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut pixels = vec![0; 24];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height, info.color_type), (3, 2, png::ColorType::Rgba));
        assert_eq!(pixels, image.pixels().as_flattened());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "the temporary file is gone");
    }

    #[test]
    fn pictures_that_png_cannot_hold_are_refused() {
        assert!(matches!(Image::new(0, 4, [0; 4]).encode_png(), Err(PictureError::Size { .. })));
        let missing = save(Path::new("/no/such/folder/picture.png"), &[]);
        assert!(missing.unwrap_err().to_string().contains("/no/such/folder/picture.png"));
    }

    #[test]
    fn pasting_and_covering_stay_inside() {
        let mut image = Image::new(2, 2, [0, 0, 0, 255]);
        image.paste(&Image::new(5, 5, [9, 9, 9, 255]), 1, 1);
        image.cover(-1, 0, [255; 3], 1.0);
        image.cover(0, 7, [255; 3], 1.0);
        image.cover(0, 0, [200, 100, 0], 0.5);
        assert_eq!(image.pixels(), [[100, 50, 0, 255], [0, 0, 0, 255], [0, 0, 0, 255], [9, 9, 9, 255]]);
    }
}
