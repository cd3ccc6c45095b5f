//! Small print on an image, in the Noto Sans Mono bitmaps of the `noto-sans-mono-bitmap` crate.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use super::image::Image;

/// How letters look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Style {
    /// Labels.
    Plain,
    /// Headings.
    Bold,
}

/// Where a text stands relative to its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Align {
    /// It begins there.
    Left,
    /// Its middle is there.
    Centre,
    /// It ends there.
    Right,
}

/// The height of a line, in pixels.
pub(super) const LINE: usize = 16;

impl Style {
    fn font(self) -> FontWeight {
        match self {
            Self::Plain => FontWeight::Regular,
            Self::Bold => FontWeight::Bold,
        }
    }
}

/// The width of a text, in pixels.
pub(super) fn width(text: &str, style: Style) -> usize {
    text.chars().count() * get_raster_width(style.font(), RasterHeight::Size16)
}

/// Draws a line of text with its top at `row`. Letters that the font has not are drawn as `?`.
pub(super) fn draw(image: &mut Image, column: i64, row: i64, text: &str, style: Style, align: Align, colour: [u8; 3]) {
    let whole = width(text, style) as i64;
    let mut left = match align {
        Align::Left => column,
        Align::Centre => column - whole / 2,
        Align::Right => column - whole,
    };
    for letter in text.chars() {
        let raster = |letter| get_raster(letter, style.font(), RasterHeight::Size16);
        let Some(glyph) = raster(letter).or_else(|| raster('?')) else { continue };
        for (down, line) in glyph.rows().enumerate() {
            for (across, &weight) in line.iter().enumerate() {
                image.cover(left + across as i64, row + down as i64, colour, f32::from(weight) / 255.0);
            }
        }
        left += glyph.width() as i64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The columns and rows that are not plain.
    fn inked(image: &Image) -> Vec<(usize, usize)> {
        let place = |index: usize| (index % image.width(), index / image.width());
        let dark = |&index: &usize| image.pixels()[index] != [255; 4];
        (0..image.pixels().len()).filter(dark).map(place).collect()
    }

    #[test]
    fn text_stands_where_it_is_told() {
        let drawn = |align| {
            let mut image = Image::new(100, 20, [255; 4]);
            draw(&mut image, 50, 2, "48", Style::Bold, align, [0; 3]);
            inked(&image)
        };
        assert!(drawn(Align::Left).iter().all(|&(column, row)| column >= 50 && (2..18).contains(&row)));
        assert!(drawn(Align::Right).iter().all(|&(column, _)| column < 50));
        let centred = drawn(Align::Centre);
        assert!(centred.iter().any(|&(column, _)| column < 50) && centred.iter().any(|&(column, _)| column > 50));
    }

    #[test]
    fn any_letter_is_drawn_and_none_outside() {
        let mut image = Image::new(12, 12, [255; 4]);
        draw(&mut image, -5, -5, "\u{1F98A}\u{0}x", Style::Plain, Align::Left, [0; 3]);
        assert!(!inked(&image).is_empty());
    }
}
