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

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::field::{Expression, Graph};

    #[test]
    fn rings_by_value() {
        let mut graph = Graph::new();
        let x = graph.x();
        let colours: Vec<LinearRgb> = (0..3).map(|i| [i as f32, 0.0, 0.0]).collect();
        let bands = Bands::new(Arc::new(Expression::new(&graph, x)), 0.5, colours).expect("bands");
        let mut points = Points::new(DVec3::ZERO);
        [0.1, 0.6, 1.4, 1.6, -0.1, -0.6, -1.4, -1.6].iter().for_each(|x| points.push(Vec3::new(*x, 0.0, 0.0)));
        let mut out = [[0.0; 3]; BATCH];
        bands.sampler().sample(&points, &mut out);
        assert_eq!(
            out[..8].iter().map(|colour| colour[0]).collect::<Vec<_>>(),
            [0.0, 1.0, 2.0, 0.0, 2.0, 1.0, 0.0, 2.0]
        );
        assert!(Bands::new(Arc::new(Expression::new(&graph, x)), 0.0, vec![[0.0; 3]]).is_none());
    }
}
