//! What is made of the frames: the name of the output says it.

use std::path::{Path, PathBuf};

use super::picture::Painter;
use super::source::Shown;
use crate::bake::FramePattern;
use crate::cli::failure::Failure;
use crate::render::{Animation, ContactSheet, Image, save};
use crate::terminal;

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Png,
    Apng,
    Exr,
}

/// Where pictures go.
pub struct Target {
    pub kind: Kind,
    pattern: FramePattern,
}

impl Target {
    /// Reads the name of the output.
    pub fn new(output: &Path) -> Result<Self, Failure> {
        let end = output.extension().and_then(|end| end.to_str()).unwrap_or_default().to_ascii_lowercase();
        let (kind, end) = match end.as_str() {
            "png" => (Kind::Png, "png"),
            "apng" => (Kind::Apng, "apng"),
            "exr" => (Kind::Exr, "exr"),
            _ => {
                let problem = "a preview is a .png (a picture or a contact sheet), an .apng (animated) or an .exr";
                return Err(Failure::usage(format!("{}: {problem}", terminal::path(output))));
            }
        };
        let pattern = FramePattern::new(output, &[end])?;
        if kind == Kind::Apng && pattern.has_token() {
            let problem = "an .apng holds all frames: leave the frame token out";
            return Err(Failure::usage(format!("{}: {problem}", terminal::path(output))));
        }
        Ok(Self { kind, pattern })
    }
}

/// Writes what is made of the frames.
pub struct Writer<'a> {
    target: &'a Target,
    /// The numbers of the frames that are pictured.
    numbers: &'a [i64],
    size: usize,
    form: Form,
    written: Vec<PathBuf>,
}

enum Form {
    /// Each frame is a file.
    Files,
    /// All are one file: a contact sheet.
    Sheet,
    /// All are one file: the pictures, with the numbers of their frames.
    Animation { fps: f64, images: Vec<(Image, i64)> },
}

impl<'a> Writer<'a> {
    /// For the pictures of some of `count` frames, those of these numbers. `size` is the edge of a picture, if it was
    /// asked for.
    pub fn new(target: &'a Target, numbers: &'a [i64], count: usize, size: Option<u32>) -> Result<Self, Failure> {
        let (form, default) = match target.kind {
            Kind::Apng => (Form::Animation { fps: 24.0, images: Vec::with_capacity(numbers.len()) }, 480),
            Kind::Png if !target.pattern.has_token() && count > 1 => (Form::Sheet, 220),
            Kind::Png | Kind::Exr => {
                target.pattern.holds(numbers.len())?;
                (Form::Files, 800)
            }
        };
        let size = size.map_or(default, |size| size as usize);
        Ok(Self { target, numbers, size, form, written: Vec::new() })
    }

    /// The edge of a picture in pixels.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Whether a contact sheet is made, which tells of all frames.
    pub fn wants_sheet(&self) -> bool {
        matches!(self.form, Form::Sheet)
    }

    /// Takes a picture of a frame; it is given back where it goes onto a contact sheet.
    pub fn take(&mut self, painter: &mut Painter<'_>, shown: &Shown, number: i64) -> Result<Option<Image>, Failure> {
        if self.target.kind == Kind::Exr {
            let bytes = painter.layers(shown).encode_exr().map_err(failed)?;
            self.write(number, &bytes)?;
            return Ok(None);
        }
        let image = painter.image(shown);
        match &mut self.form {
            Form::Sheet => return Ok(Some(image)),
            Form::Files => self.write(number, &image.encode_png().map_err(failed)?)?,
            Form::Animation { fps, images } => {
                *fps = shown.fps;
                images.push((image, number));
            }
        }
        Ok(None)
    }

    fn write(&mut self, number: i64, bytes: &[u8]) -> Result<(), Failure> {
        let path = self.target.pattern.file(number);
        save(&path, bytes).map_err(failed)?;
        self.written.push(path);
        Ok(())
    }

    /// Writes what holds all frames, and tells of all files that were written.
    pub fn finish(mut self, sheet: &ContactSheet) -> Result<Vec<PathBuf>, Failure> {
        match std::mem::replace(&mut self.form, Form::Files) {
            Form::Files => {}
            Form::Sheet => self.write(0, &sheet.compose().encode_png().map_err(failed)?)?,
            Form::Animation { fps, images } => {
                let mut bytes = Vec::new();
                let mut animation =
                    Animation::new(&mut bytes, self.size, self.size, images.len(), fps).map_err(failed)?;
                for (place, (image, number)) in images.into_iter().enumerate() {
                    animation.add(image, number, self.lasts(place)).map_err(failed)?;
                }
                animation.finish().map_err(failed)?;
                self.write(0, &bytes)?;
            }
        }
        Ok(self.written)
    }

    /// For how many frames a picture is shown: until the next one, the last as long as the one before it.
    fn lasts(&self, place: usize) -> i64 {
        let place = place.min(self.numbers.len().saturating_sub(2));
        match self.numbers.get(place..place + 2) {
            Some([this, next]) => next.saturating_sub(*this).max(1),
            _ => 1,
        }
    }
}

fn failed(error: crate::render::PictureError) -> Failure {
    Failure::work(error.to_string())
}
