//! How the signed distance to a field's zero set is measured: one method, one file here and one row of [`METHODS`].

mod adf;
pub mod blocks;
mod choice;
mod closest_point;
pub mod fim;
mod godunov;
pub mod lattice;
mod own_sign;
mod rough;
pub mod rounds;
mod vector_dt;

#[cfg(test)]
mod tests;

use std::sync::Arc;

pub use choice::{AsChosen, Choice, DEPTHS};
use own_sign::OwnSign;
pub(crate) use rough::Rough;

use super::Distance;
use super::nearest::Watch;
use super::octree::{BuildError, DistanceObject, Report, Settings};
use crate::field::{Aabb, Field};
use crate::grid::Band;

/// All methods that have a name; the first is the usual one.
pub static METHODS: [&dyn Method; 4] = [&closest_point::ClosestPoint, &vector_dt::VectorDt, &fim::Fim, &adf::Adf];

/// What to measure.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// What the distance is to: its zero set.
    pub field: &'a Arc<dyn Field>,
    /// A box that holds all of the zero set.
    pub solid: Aabb,
    /// How fine the zero set is, world units: a voxel or two. Greater may miss details, smaller takes longer.
    pub detail: f64,
    /// Where distances are asked for, and how finely.
    pub settings: Settings,
}

/// A distance that was measured.
#[derive(Clone)]
pub struct Measured {
    /// The distance, everywhere.
    pub distance: Arc<dyn Distance>,
    /// Memory that it holds.
    pub bytes: u64,
    /// What of it is kept as bytes, for [`Method::restored`].
    pub object: Arc<DistanceObject>,
}

impl Measured {
    /// What a distance object tells.
    pub fn of(object: Arc<DistanceObject>) -> Self {
        Self { bytes: object.report().bytes as u64, distance: Arc::clone(&object) as _, object }
    }

    /// The same with F's own sign.
    fn signed(object: Arc<DistanceObject>, field: &Arc<dyn Field>) -> Self {
        let distance = Arc::new(OwnSign { magnitude: Arc::clone(&object) as _, field: Arc::clone(field) });
        Self { distance, ..Self::of(object) }
    }
}

/// A distance in the plane that was measured.
#[derive(Clone)]
pub struct MeasuredInPlane {
    /// The distance, everywhere.
    pub distance: Arc<dyn Distance>,
    /// The quadtree that restores it.
    pub report: Report,
}

/// A way to measure distances.
pub trait Method: Sync {
    /// What it is called.
    fn name(&self) -> &'static str;

    /// Measures a distance.
    ///
    /// # Errors
    /// Those of the method; [`BuildError::Cancelled`] once the watch says so.
    fn measure(&self, request: &Request<'_>, watch: &Watch<'_>) -> Result<Measured, BuildError>;

    /// Measures the distance of a field that does not know z, in the plane: the request's z is of no account.
    ///
    /// # Errors
    /// [`BuildError::SolidsOnly`] where the method measures solids only; else those of [`Self::measure`].
    fn measure_in_plane(&self, _request: &Request<'_>, _watch: &Watch<'_>) -> Result<MeasuredInPlane, BuildError> {
        Err(BuildError::SolidsOnly { method: self.name() })
    }

    /// Memory that a node takes while a band is measured, in bytes, beside the band itself.
    fn bytes_a_node(&self) -> usize {
        0
    }

    /// What was measured of `field` and kept as bytes.
    fn restored(&self, object: Arc<DistanceObject>, _field: &Arc<dyn Field>) -> Measured {
        Measured::of(object)
    }

    /// Puts its distances, as they were chosen, in the place of those of a band of `field`, which are those to closest points
    /// and stay unless a method has others. Signs, and which voxels are active, always stay.
    ///
    /// # Errors
    /// Those of the method; [`BuildError::Cancelled`] once the watch says so.
    fn measure_band(
        &self,
        _field: &dyn Field,
        _band: &mut Band,
        _as_chosen: AsChosen,
        _watch: &Watch<'_>,
    ) -> Result<(), BuildError> {
        Ok(())
    }
}

/// What scenes call the methods, in the order of [`METHODS`].
pub const NAMES: [&str; METHODS.len()] = ["closest-point", "vector-dt", "fim", "adf"];

/// The usual method.
pub const USUAL: &str = NAMES[0];

/// The one that takes a depth.
pub const ADF: &str = NAMES[3];

/// The method of a name; the usual one of a name that is none.
pub fn named(name: &str) -> &'static dyn Method {
    METHODS.into_iter().find(|method| method.name() == name).unwrap_or(METHODS[0])
}
