//! A shape that stays while attributes alone go over (STTI §6.3).

use std::sync::Arc;

use super::{Between, Combine, Mode, Placed};
use crate::field::Field;
use crate::morph::coarse::{CoarseGrid, Measured};
use crate::morph::volume::object_fractions;

/// The first object's shape all along.
#[derive(Clone, Debug)]
pub struct Still;

impl Mode for Still {
    fn carries(&self) -> bool {
        false
    }

    fn stays(&self) -> bool {
        true
    }

    fn between(&self, _t: f64, _time: f64) -> Between<'_> {
        Between::Formula(Box::new(First))
    }
}

/// f₁.
struct First;

impl Combine for First {
    fn field(&self, pair: &Placed) -> Arc<dyn Field> {
        Arc::clone(&pair.surfaces[0])
    }

    fn fractions(&self, grid: &CoarseGrid, measured: &Measured, unit: f64) -> Vec<f32> {
        object_fractions(grid, &measured.first, unit)
    }
}
