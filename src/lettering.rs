//! Text as closed curves: a font's outlines, placed by its own kerning and ligatures (OpenType shaping), line by line.
//!
//! Outlines of one font overlap where letters join and where a letter is built of strokes: they are filled by their winding
//! number, as fonts mean them. Not done: lines that mix directions of writing, and breaking lines that are too long.

use glam::DVec2;
use harfrust::{Buffer, Feature, ShapeOptions, ShaperFont, Tag, shape};
use skrifa::{DrawMemory, Font as Face, GlyphId, PathSink, ScalerFont};

use crate::field::Drawing;

/// The font inside the program.
static BUILT_IN: &[u8] = include_bytes!("../fonts/noto-sans-semibold.ttf");

/// How far curves may be off, of the em: a hundredth of a voxel where a line of ten letters has 2000 voxels.
const TOLERANCE: f64 = 2e-5;

/// Corners of all letters together: some thousand letters.
const MOST_CORNERS: usize = 2_000_000;

/// A font.
pub struct Font(Face);

/// Where lines stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// They begin at x = 0.
    Left,
    /// Each around x = 0.
    Center,
    /// They end at x = 0.
    Right,
}

/// What the size is the height of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SizeOf {
    /// A capital letter.
    Capitals,
    /// The font's em.
    Em,
}

/// How text is set.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// The size.
    pub size: f64,
    /// What it is the height of.
    pub size_of: SizeOf,
    /// Where lines stand.
    pub align: Align,
    /// From baseline to baseline, of the font's own distance.
    pub line_spacing: f64,
    /// What is added between letters.
    pub letter_spacing: f64,
}

/// Why text cannot be set.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// The font has no glyph for a character.
    NoGlyph(char),
    /// The glyph of a character is broken in the font.
    BrokenGlyph(char),
    /// The font cannot shape the text.
    NoShape,
    /// There are too many letters.
    TooLong,
}

impl Font {
    /// The font inside the program.
    pub fn built_in() -> Self {
        Self(Face::new(BUILT_IN, 0).expect("it is a font"))
    }

    /// The first font of a file: TrueType, OpenType, or a collection of them; `None` where it is none.
    pub fn new(file: Vec<u8>) -> Option<Self> {
        let face = Face::new(file, 0)?;
        (face.num_glyphs() > 0).then_some(Self(face))
    }

    /// The curves of a text, its lines one below the other: from the top of the first line's capitals to the last baseline
    /// it is as far up as down.
    pub fn set(&self, text: &str, setting: &Setting) -> Result<Drawing, Error> {
        let metrics = self.0.metrics();
        let em = f64::from(metrics.units_per_em);
        let capitals = self.capitals().unwrap_or(0.7 * em);
        let unit = match setting.size_of {
            SizeOf::Capitals => setting.size / capitals,
            SizeOf::Em => setting.size / em,
        };
        let apart = unit * setting.line_spacing * self.line().unwrap_or(1.2 * em);
        let lines: Vec<&str> = text.lines().collect();
        let height = capitals * unit + apart * lines.len().saturating_sub(1) as f64;
        let first = height / 2.0 - capitals * unit;
        let scaler = ScalerFont::unhinted(self.0.clone(), None);
        let shaper = ShaperFont::new(&self.0);
        // Letters that stand apart are not drawn as one.
        let apart_features = [Tag::new(b"liga"), Tag::new(b"clig")].map(|tag| Feature::new(tag, 0, ..));
        let features: &[Feature] = if setting.letter_spacing == 0.0 { &[] } else { &apart_features };
        let mut drawing = Drawing::new(TOLERANCE * em * unit);
        for (number, line) in lines.into_iter().enumerate() {
            let mut buffer = Buffer::new();
            buffer.push_str(line);
            buffer.guess_segment_properties();
            shape(&shaper, &mut buffer, ShapeOptions::new().features(features)).map_err(|_| Error::NoShape)?;
            let glyphs = || buffer.glyph_infos().iter().zip(buffer.glyph_positions());
            let gaps = buffer.glyph_infos().len().saturating_sub(1) as f64;
            let width = glyphs().map(|(_, place)| f64::from(place.x_advance)).sum::<f64>() * unit
                + gaps * setting.letter_spacing;
            let mut x = match setting.align {
                Align::Left => 0.0,
                Align::Center => -width / 2.0,
                Align::Right => -width,
            };
            for (glyph, place) in glyphs() {
                let letter = || line.get(glyph.cluster as usize..).and_then(|rest| rest.chars().next()).unwrap_or('?');
                if glyph.glyph_id == 0 {
                    return Err(Error::NoGlyph(letter()));
                }
                let moved = DVec2::new(f64::from(place.x_offset), f64::from(place.y_offset)) * unit;
                let origin = DVec2::new(x, first - apart * number as f64) + moved;
                let mut pen = Pen { drawing: &mut drawing, origin, unit };
                // A blank has no outline.
                if let Some(outline) = scaler.outline(GlyphId::new(glyph.glyph_id)) {
                    outline.draw(DrawMemory::Scratch, &mut pen).map_err(|_| Error::BrokenGlyph(letter()))?;
                }
                if drawing.corners() > MOST_CORNERS {
                    return Err(Error::TooLong);
                }
                x += f64::from(place.x_advance) * unit + setting.letter_spacing;
            }
        }
        Ok(drawing)
    }

    /// The height of a capital letter, font units.
    fn capitals(&self) -> Option<f64> {
        let told = self.0.metrics().cap_height.map(|height| height.to_f64());
        told.filter(|height| *height > 0.0)
    }

    /// From baseline to baseline, font units.
    fn line(&self) -> Option<f64> {
        let metrics = self.0.metrics();
        let chosen = if metrics.use_typo_metrics { metrics.typo_line } else { metrics.hhea_line };
        let line = chosen.or(metrics.typo_line)?;
        let height = line.ascender.to_f64() - line.descender.to_f64() + line.line_gap.to_f64();
        (height > 0.0).then_some(height)
    }
}

/// Draws a glyph.
struct Pen<'d> {
    drawing: &'d mut Drawing,
    origin: DVec2,
    unit: f64,
}

impl Pen<'_> {
    fn at(&self, x: f32, y: f32) -> DVec2 {
        self.origin + DVec2::new(x.into(), y.into()) * self.unit
    }
}

impl PathSink for Pen<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        self.drawing.begin(self.at(x, y));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.drawing.line(self.at(x, y));
    }

    fn quad_to(&mut self, cx: f32, cy: f32, x: f32, y: f32) {
        self.drawing.quadratic(self.at(cx, cy), self.at(x, y));
    }

    fn curve_to(&mut self, cx: f32, cy: f32, dx: f32, dy: f32, x: f32, y: f32) {
        self.drawing.cubic(self.at(cx, cy), self.at(dx, dy), self.at(x, y));
    }

    fn close(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Fill;

    const PLAIN: Setting =
        Setting { size: 1.0, size_of: SizeOf::Capitals, align: Align::Center, line_spacing: 1.0, letter_spacing: 0.0 };

    /// The box of what a text fills.
    fn extent(text: &str, setting: &Setting) -> [DVec2; 2] {
        let loops = Font::built_in().set(text, setting).unwrap().filled(Fill::NonZero);
        let all = loops.iter().flatten().map(|corner| DVec2::from(*corner));
        all.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[min, max], at| [min.min(at), max.max(at)])
    }

    #[test]
    fn capitals_are_as_high_as_the_size() {
        let [min, max] = extent("H", &PLAIN);
        assert!((min.y + 0.5).abs() < 1e-3 && (max.y - 0.5).abs() < 1e-3, "{min} {max}");
        let [min, max] = extent("H", &Setting { size_of: SizeOf::Em, ..PLAIN });
        assert!((max.y - min.y - 0.714).abs() < 1e-3, "{min} {max}");
        let [min, max] = extent("H\nH", &PLAIN);
        assert!((max.y + min.y).abs() < 1e-3 && max.y - min.y > 2.0, "{min} {max}");
    }

    #[test]
    fn lines_stand_where_they_are_aligned() {
        let [left, _] = extent("HI", &Setting { align: Align::Left, ..PLAIN });
        let [_, right] = extent("HI", &Setting { align: Align::Right, ..PLAIN });
        assert!(left.x > 0.0 && left.x < 0.2 && right.x < 0.0 && right.x > -0.2, "{left} {right}");
    }

    /// The A moves below the overhang of the V, and spacing moves letters apart.
    #[test]
    fn kerning_and_spacing() {
        let width = |text: &str, spacing: f64| {
            let [min, max] = extent(text, &Setting { letter_spacing: spacing, ..PLAIN });
            max.x - min.x
        };
        assert!(width("AV", 0.0) < width("A", 0.0) + width("V", 0.0) - 0.05);
        assert!((width("AV", 0.3) - width("AV", 0.0) - 0.3).abs() < 1e-9);
    }

    #[test]
    fn what_cannot_be_set() {
        let font = Font::built_in();
        assert_eq!(font.set("a\u{4e2d}", &PLAIN).err(), Some(Error::NoGlyph('\u{4e2d}')));
        assert_eq!(font.set(&"8".repeat(100_000), &PLAIN).err(), Some(Error::TooLong));
        // Fonts that are cut off or garbled.
        assert!(Font::new(Vec::new()).is_none() && Font::new(b"no font at all, but text".to_vec()).is_none());
        for step in 0..400 {
            let mut broken = BUILT_IN.to_vec();
            if step % 2 == 0 {
                broken.truncate(BUILT_IN.len() * step / 400);
            } else {
                let at = step * 7919 * 13 % BUILT_IN.len();
                broken[at..(at + 64).min(BUILT_IN.len())]
                    .iter_mut()
                    .for_each(|byte| *byte = byte.wrapping_mul(31) ^ 0xa5);
            }
            if let Some(font) = Font::new(broken) {
                let _ = font.set("Ag\u{e9}8", &PLAIN).map(|drawing| drawing.filled(Fill::NonZero));
            }
        }
    }
}
