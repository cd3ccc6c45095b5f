//! Rings of colour by distance.

use std::sync::Arc;

use super::{Colour, ColourSampler, LinearRgb};
use crate::field::{Aabb, BATCH, Evaluator, Field, Points};

/// Colours in turn, band after band of a field's value: rings around its surface.
pub struct Bands {
    field: Arc<dyn Field>,
    width: f64,
    colours: Vec<LinearRgb>,
}

impl Bands {
    /// Bands of `width` in the field's value, the first colour's just inside F = 0, the second's next further in, and so
    /// on, outside likewise backwards. `None` where the width is not a finite positive number or there are no colours.
    pub fn new(field: Arc<dyn Field>, width: f64, colours: Vec<LinearRgb>) -> Option<Self> {
        let sound = width.is_finite() && width > 0.0 && !colours.is_empty();
        sound.then_some(Self { field, width, colours })
    }
}

impl Colour for Bands {
    fn sampler(&self) -> Box<dyn ColourSampler + '_> {
        Box::new(BandsSampler { bands: self, evaluator: self.field.evaluator(), values: [0.0; BATCH] })
    }
}

struct BandsSampler<'a> {
    bands: &'a Bands,
    evaluator: Box<dyn Evaluator + 'a>,
    values: [f32; BATCH],
}

impl ColourSampler for BandsSampler<'_> {
    // No region is entered: pruning keeps a field's zero set, but here its values count.
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [LinearRgb; BATCH]) {
        self.evaluator.values(points, &mut self.values);
        let colours = &self.bands.colours;
        let per_width = (1.0 / self.bands.width) as f32;
        for (value, out) in self.values[..points.len].iter().zip(out) {
            let band = (value * per_width).floor() as i64;
            *out = colours[band.rem_euclid(colours.len() as i64) as usize];
        }
    }
}
