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
    /// The files; none where the terminal is all.
    pattern: Option<FramePattern>,
    in_terminal: bool,
}

impl Target {
    /// Reads the name of the output; none where the terminal is all.
    pub fn new(output: Option<&Path>, in_terminal: bool) -> Result<Self, Failure> {
        let Some(output) = output else { return Ok(Self { kind: Kind::Png, pattern: None, in_terminal }) };
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
        if in_terminal && kind != Kind::Png {
            return Err(Failure::usage("a terminal shows what a .png holds: name one, or leave --output out"));
        }
        Ok(Self { kind, pattern: Some(pattern), in_terminal })
    }

    /// Whether each of so many frames is a file of its own.
    fn is_each(&self, count: usize) -> bool {
        let has_token = self.pattern.as_ref().is_some_and(FramePattern::has_token);
        self.kind == Kind::Exr || (self.kind == Kind::Png && (has_token || count == 1))
    }

    /// The edge of a picture of so many frames in pixels, if none was asked for.
    pub fn size(&self, count: usize) -> u32 {
        match self.kind {
            Kind::Apng => 480,
            _ if self.is_each(count) => 800,
            _ => 220,
        }
    }

    /// The one file that is written, if there is one.
    pub fn file(&self) -> Option<PathBuf> {
        self.pattern.as_ref().filter(|pattern| !pattern.has_token()).map(|pattern| pattern.file(0))
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
    /// For the pictures, `size` pixels each way, of some of `count` frames, those of these numbers.
    pub fn new(target: &'a Target, numbers: &'a [i64], count: usize, size: usize) -> Result<Self, Failure> {
        let form = match target.kind {
            Kind::Apng => Form::Animation { fps: 24.0, images: Vec::with_capacity(numbers.len()) },
            _ if !target.is_each(count) => Form::Sheet,
            _ => {
                if let Some(pattern) = &target.pattern {
                    pattern.holds(numbers.len())?;
                }
                Form::Files
            }
        };
        Ok(Self { target, numbers, size, form, written: Vec::new() })
    }

    /// Whether a contact sheet is made, which tells of all frames.
    pub fn wants_sheet(&self) -> bool {
        matches!(self.form, Form::Sheet)
    }

    /// Takes a picture of a frame; it is given back where it goes onto a contact sheet.
    pub fn take(&mut self, painter: &mut Painter<'_>, shown: &Shown, number: i64) -> Result<Option<Image>, Failure> {
        if self.target.kind == Kind::Exr {
            let bytes = painter.exr(shown).map_err(failed)?;
            self.write(number, &bytes)?;
            return Ok(None);
        }
        let image = painter.image(shown);
        match &mut self.form {
            Form::Sheet => return Ok(Some(image)),
            Form::Files => self.picture(number, &image)?,
            Form::Animation { fps, images } => {
                *fps = shown.fps;
                images.push((image, number));
            }
        }
        Ok(None)
    }

    fn picture(&mut self, number: i64, image: &Image) -> Result<(), Failure> {
        if self.target.in_terminal {
            super::terminal::show(image)?;
        }
        if self.target.pattern.is_some() {
            self.write(number, &image.encode_png().map_err(failed)?)?;
        }
        Ok(())
    }

    fn write(&mut self, number: i64, bytes: &[u8]) -> Result<(), Failure> {
        let Some(pattern) = &self.target.pattern else { return Ok(()) };
        let path = pattern.file(number);
        save(&path, bytes).map_err(failed)?;
        self.written.push(path);
        Ok(())
    }

    /// Writes what holds all frames, and tells of all files that were written.
    pub fn finish(mut self, sheet: &ContactSheet) -> Result<Vec<PathBuf>, Failure> {
        match std::mem::replace(&mut self.form, Form::Files) {
            Form::Files => {}
            Form::Sheet => self.picture(0, &sheet.compose())?,
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
