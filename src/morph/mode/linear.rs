//! Linear blending: what space-time blending is compared with.

use std::sync::Arc;

use super::{Between, Combine, Mode, Pace, Placed, expression};
use crate::field::{Field, Graph};
use crate::morph::coarse::{CoarseGrid, Measured};
use crate::morph::volume::{NO_SLOPE, fraction};

/// (1 − t)·f₁ + t·f₂ of the two distances.
#[derive(Clone, Debug, Default)]
pub struct Linear {
    /// How t follows the morph's progress.
    pub pace: Pace,
}

impl Mode for Linear {
    fn pace(&self) -> Pace {
        self.pace
    }

    fn between(&self, t: f64, _time: f64) -> Between<'_> {
        Between::Formula(Box::new(At(t)))
    }
}

/// At this t.
struct At(f64);

impl Combine for At {
    fn field(&self, pair: &Placed) -> Arc<dyn Field> {
        let [first, second] = &pair.distances;
        // Where both are negative so is the sum.
        let boxes = [first.bounding_box(), second.bounding_box()];
        let mut graph = Graph::new();
        let (one, two) = (graph.field(first.clone()), graph.field(second.clone()));
        let (one, two) = (graph.linear(one, 1.0 - self.0, 0.0), graph.linear(two, self.0, 0.0));
        let sum = graph.add(one, two);
        expression(&graph, sum, boxes)
    }

    fn fractions(&self, grid: &CoarseGrid, measured: &Measured, unit: f64) -> Vec<f32> {
        let (per_edge, one, two) = ((unit / grid.edge()) as f32, (1.0 - self.0) as f32, self.0 as f32);
        let cells = measured.first.iter().zip(&measured.second).zip(&measured.cosine);
        let inside = |((first, second), cosine): ((&f32, &f32), &f32)| {
            let square = one * one + two * two + 2.0 * one * two * cosine;
            fraction((one * first + two * second) / square.max(NO_SLOPE).sqrt() * per_edge)
        };
        cells.map(inside).collect()
    }
}
