//! The plain union on the way, edges included: what space-time blending smooths out.

use std::sync::Arc;

use super::{Between, Combine, Mode, Placed, expression};
use crate::field::{Field, Graph, SetSystem};
use crate::morph::coarse::{CoarseGrid, Measured};
use crate::morph::volume::fraction;

/// Both objects at once between the ends, by max.
#[derive(Clone, Debug)]
pub struct Union;

impl Mode for Union {
    fn carries(&self) -> bool {
        false
    }

    fn between(&self, _t: f64, _time: f64) -> Between<'_> {
        Between::Formula(Box::new(Both))
    }
}

/// max(f₁, f₂).
struct Both;

impl Combine for Both {
    fn field(&self, pair: &Placed) -> Arc<dyn Field> {
        let boxes = pair.surfaces.each_ref().map(|surface| surface.bounding_box());
        let mut graph = Graph::new();
        let solids = pair.surfaces.each_ref().map(|surface| graph.field(Arc::clone(surface)));
        let joined = graph.union(SetSystem::MinMax, &solids);
        expression(&graph, joined, boxes)
    }

    fn fractions(&self, grid: &CoarseGrid, measured: &Measured, unit: f64) -> Vec<f32> {
        let per_edge = (unit / grid.edge()) as f32;
        let cells = measured.first.iter().zip(&measured.second);
        cells.map(|(first, second)| fraction(first.max(*second) * per_edge)).collect()
    }
}
