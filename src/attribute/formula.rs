//! Colour by three formulas.

use std::sync::Arc;

use super::{Colour, ColourSampler, ColourSpace, LinearRgb, from_srgb};
use crate::field::{Aabb, BATCH, Evaluator, Field, Points};

/// What a formula's three numbers are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Components {
    /// Scene-linear red, green, blue.
    Linear,
    /// sRGB-encoded red, green, blue, 0…1.
    Srgb,
    /// Hue in degrees, saturation and value, 0…1, of the sRGB-encoded colour.
    Hsv,
}

/// A colour whose components are fields. Their values are taken as they come, negative or not a number included.
pub struct Formula {
    /// One field a component.
    pub components: [Arc<dyn Field>; 3],
    /// What they are.
    pub meaning: Components,
}

impl Colour for Formula {
    fn sampler(&self) -> Box<dyn ColourSampler + '_> {
        let evaluators = self.components.each_ref().map(|field| field.evaluator());
        Box::new(FormulaSampler { evaluators, meaning: self.meaning, values: [[0.0; BATCH]; 3] })
    }
}

struct FormulaSampler<'a> {
    evaluators: [Box<dyn Evaluator + 'a>; 3],
    meaning: Components,
    values: [[f32; BATCH]; 3],
}

impl ColourSampler for FormulaSampler<'_> {
    // The fields enter no region: pruning keeps their zero sets, but here their values count.
    fn enter(&mut self, _region: &Aabb) {}

    fn leave(&mut self) {}

    fn sample(&mut self, points: &Points, out: &mut [LinearRgb; BATCH]) {
        for (evaluator, values) in self.evaluators.iter_mut().zip(&mut self.values) {
            evaluator.values(points, values);
        }
        for (i, out) in out[..points.len].iter_mut().enumerate() {
            let numbers = self.values.each_ref().map(|values| values[i]);
            *out = match self.meaning {
                Components::Linear => numbers,
                Components::Srgb => from_srgb(numbers),
                Components::Hsv => ColourSpace::Hsv.decode(numbers),
            };
        }
    }
}
