//! An animated picture (APNG): browsers play it, and what knows PNG alone shows its first frame.

use super::{
    error::{PictureError, png_size},
    image::Image,
    text::{self, Align, LINE, Style},
};

/// Room around a frame's number, in pixels.
const MARGIN: usize = 8;
/// Pictures smaller than this have no room for a number.
const LEAST_LABELLED: usize = 100;
const INK: [u8; 3] = [52, 58, 70];

/// Pictures of one size that are shown one after the other, for ever.
pub struct Animation<'a> {
    writer: png::Writer<&'a mut Vec<u8>>,
    fps: f64,
}

impl<'a> Animation<'a> {
    /// Begins the file of an animation of `count` pictures (at least one) at `fps` frames a second.
    ///
    /// # Errors
    /// [`PictureError::Size`].
    pub fn new(
        bytes: &'a mut Vec<u8>,
        width: usize,
        height: usize,
        count: usize,
        fps: f64,
    ) -> Result<Self, PictureError> {
        let (across, down) = png_size(width, height)?;
        let mut encoder = png::Encoder::new(bytes, across, down);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.validate_sequence(true);
        encoder.set_animated(u32::try_from(count).unwrap_or(u32::MAX), 0)?;
        Ok(Self { writer: encoder.write_header()?, fps })
    }

    /// Adds a picture that is shown for `frames` frames, with its number in the lower left corner.
    ///
    /// # Errors
    /// [`PictureError::Png`]: a picture of another size, or one too many.
    pub fn add(&mut self, mut image: Image, number: i64, frames: i64) -> Result<(), PictureError> {
        if image.width().min(image.height()) >= LEAST_LABELLED {
            let row = image.height() - LINE - MARGIN;
            text::draw(&mut image, MARGIN as i64, row as i64, &number.to_string(), Style::Plain, Align::Left, INK);
        }
        let (numerator, denominator) = delay(frames, self.fps);
        self.writer.set_frame_delay(numerator, denominator)?;
        self.writer.write_image_data(image.pixels().as_flattened())?;
        Ok(())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// [`PictureError::Png`]: fewer pictures than were promised.
    pub fn finish(self) -> Result<(), PictureError> {
        Ok(self.writer.finish()?)
    }
}

/// How long some frames last, as APNG has it: a fraction of a second.
fn delay(frames: i64, fps: f64) -> (u16, u16) {
    // 23.976 frames a second are 1000/23976 s each; two decimals fit in 16 bits.
    let denominator = (fps * 100.0).round().clamp(1.0, f64::from(u16::MAX));
    let numerator = (frames.max(1) as f64 * 100.0).min(f64::from(u16::MAX));
    (numerator as u16, denominator as u16)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Read back by the decoder: every picture, and how long it is shown.
    #[test]
    fn an_animation_reads_back_as_it_was() {
        let mut bytes = Vec::new();
        let mut animation = Animation::new(&mut bytes, 40, 30, 3, 24.0).unwrap();
        for (shade, frames) in [(10, 1), (20, 4), (30, 1)] {
            animation.add(Image::new(40, 30, [shade, 0, 0, 255]), 7, frames).unwrap();
        }
        animation.finish().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let control = reader.info().animation_control.unwrap();
        assert_eq!((control.num_frames, control.num_plays), (3, 0));
        let mut pixels = vec![0; 40 * 30 * 4];
        for (shade, seconds) in [(10, 1.0 / 24.0), (20, 4.0 / 24.0), (30, 1.0 / 24.0)] {
            reader.next_frame(&mut pixels).unwrap();
            assert_eq!(pixels[..4], [shade, 0, 0, 255]);
            let control = reader.info().frame_control.unwrap();
            let shown = f64::from(control.delay_num) / f64::from(control.delay_den);
            assert!((shown - seconds).abs() < 1e-6, "{shown} s");
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let mut bytes = Vec::new();
        assert!(matches!(Animation::new(&mut bytes, 0, 3, 1, 24.0), Err(PictureError::Size { .. })));
        assert!(Animation::new(&mut bytes, 3, 3, 0, 24.0).is_err());
        let mut animation = Animation::new(&mut bytes, 3, 3, 2, 24.0).unwrap();
        animation.add(Image::new(3, 3, [0; 4]), 1, 1).unwrap();
        assert!(animation.finish().is_err(), "one picture is missing");
        for (frames, fps) in [(i64::MAX, 24.0), (1, f64::INFINITY), (-3, 0.0), (1, 23.976)] {
            let (numerator, denominator) = delay(frames, fps);
            assert!(numerator > 0 && denominator > 0);
        }
    }

    #[test]
    fn large_pictures_have_their_number() {
        let mut bytes = Vec::new();
        let mut animation = Animation::new(&mut bytes, 120, 120, 1, 24.0).unwrap();
        animation.add(Image::new(120, 120, [255; 4]), 42, 1).unwrap();
        animation.finish().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; 120 * 120 * 4];
        reader.next_frame(&mut pixels).unwrap();
        assert!(pixels[100 * 120 * 4..].contains(&INK[0]));
    }
}
