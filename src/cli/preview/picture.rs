//! A picture of one frame: from the camera, or a slice.

use std::sync::Arc;

use super::source::{Shown, Source};
use super::{Arguments, Quality, SliceOf};
use crate::attribute::Scalar;
use crate::cli::failure::Failure;
use crate::field::{Aabb, Field};
use crate::grid::measure;
use crate::render::{Camera, Fill, Image, Look, Numbers, PictureError, Scene, Shows, Slice, render, render_layers};

/// What a slice shows.
enum Of<'s> {
    Band,
    Field(&'s dyn Field, Shows),
    Scalar(&'s str, &'s Scalar, &'s dyn Field),
}

/// Takes pictures that all show the same part of the world.
pub struct Painter<'a> {
    arguments: &'a Arguments,
    source: &'a Source<'a>,
    size: usize,
    quality: Quality,
    slice: Option<Slice>,
    /// Degrees that the camera has gone around the object, for pictures of a turn.
    pub around: Option<f64>,
}

impl<'a> Painter<'a> {
    /// For pictures of so many pixels each way.
    pub fn new(
        arguments: &'a Arguments,
        source: &'a Source<'a>,
        size: usize,
        quality: Quality,
    ) -> Result<Self, Failure> {
        if let Some(plane) = arguments.slice.filter(|plane| !plane.meets(&source.bounds)) {
            let ([least, greatest], axis) = (plane.span(&source.bounds), plane.axis());
            return Err(Failure::work(format!(
                "the slice {plane} misses the object, which reaches from {axis} = {least:.4} to {greatest:.4}"
            )));
        }
        Ok(Self { arguments, source, size, quality, slice: None, around: None })
    }

    /// A picture of a frame.
    pub fn image(&mut self, shown: &Shown) -> Image {
        let Some(slice) = self.slice(shown) else {
            return render(&self.scene(shown), self.size, self.size);
        };
        match self.of(shown) {
            Of::Field(field, shows) => slice.draw_field(field, shows),
            Of::Scalar(name, scalar, field) => slice.draw_scalar(name, scalar, field),
            Of::Band => shown.inside.with_fill(|fill| slice.draw(&shown.band, fill)),
        }
    }

    /// A frame in layers, or a slice as numbers.
    pub fn exr(&mut self, shown: &Shown) -> Result<Vec<u8>, PictureError> {
        let Some(slice) = self.slice(shown) else {
            return render_layers(&self.scene(shown), self.size, self.size).encode_exr();
        };
        let field = shown.field.as_deref();
        let of_scene = shown.scalars.iter().map(|(name, scalar)| (name.clone(), Numbers::Scalar(&**scalar)));
        let of_file = shown.grids.iter().map(|(name, grid)| (name.clone(), Numbers::At(&**grid)));
        let numbers: Vec<(String, Numbers<'_>)> = of_scene.chain(of_file).collect();
        let distance = shown.distance.as_deref();
        let values = |fill: Fill<'_>| slice.values(&shown.band, distance, field, fill, &numbers);
        shown.inside.with_fill(values).encode_exr()
    }

    /// The slice that is asked for, the same for all frames.
    fn slice(&mut self, shown: &Shown) -> Option<Slice> {
        let plane = self.arguments.slice?;
        // Lines are equally far apart in all frames.
        let reach = f64::from(shown.band.background());
        let new = || {
            let slice = Slice::new(plane, self.source.bounds, self.size, reach);
            match self.of(shown) {
                Of::Field(field, shows) => slice.for_field(field, shows),
                Of::Scalar(_, scalar, field) => slice.for_scalar(scalar, field),
                Of::Band => slice,
            }
        };
        let slice = match self.slice {
            Some(slice) => slice,
            None => new(),
        };
        self.slice = Some(slice);
        Some(slice)
    }

    /// What there is to say about all pictures.
    pub fn caption(&self) -> Option<String> {
        self.slice.map(|slice| match &self.arguments.slice_of {
            SliceOf::Band => slice.caption(),
            SliceOf::Distance => slice.caption_of_field(Shows::Distance),
            SliceOf::F => slice.caption_of_field(Shows::Values),
            SliceOf::Gradient => slice.caption_of_field(Shows::Gradient),
            SliceOf::Attribute(name) => slice.caption_of(name),
        })
    }

    /// What a slice shows, as far as it was asked for and is there.
    fn of<'s>(&self, shown: &'s Shown) -> Of<'s> {
        let of_field = |field: &'s Option<Arc<dyn Field>>, shows| {
            field.as_deref().map_or(Of::Band, |field| Of::Field(field, shows))
        };
        match &self.arguments.slice_of {
            SliceOf::Band => Of::Band,
            SliceOf::Distance => of_field(&shown.distance, Shows::Distance),
            SliceOf::F => of_field(&shown.field, Shows::Values),
            SliceOf::Gradient => of_field(&shown.field, Shows::Gradient),
            SliceOf::Attribute(name) => {
                let scalar = shown.scalars.iter().find(|(own, _)| own == name);
                scalar
                    .zip(shown.field.as_deref())
                    .map_or(Of::Band, |((name, scalar), field)| Of::Scalar(name, &**scalar, field))
            }
        }
    }

    fn scene<'s>(&self, shown: &'s Shown) -> Scene<'s> {
        let own = || measure::solid_extent(&shown.band).map(|(least, greatest)| Aabb::new(least, greatest));
        let bounds = self.arguments.follow.then(own).flatten().unwrap_or(self.source.bounds);
        let Arguments { view, turn, .. } = *self.arguments;
        let camera = match self.around {
            None => Camera::framing(&bounds, shown.up, view, turn, 1.0),
            Some(degrees) => Camera::framing_all_around(&bounds, shown.up, view, turn, 1.0)
                .turned((bounds.min + bounds.max) * 0.5, degrees),
        };
        let look = Look { ground: Some(bounds.min[shown.up.axis()]), quality: self.quality.into(), ..Look::default() };
        Scene { band: &shown.band, colour: shown.colour.as_ref(), camera, look }
    }
}
