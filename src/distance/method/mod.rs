//! How the signed distance to a field's zero set is measured: one method, one file here and one row of [`METHODS`].

mod closest_point;
mod rough;

use std::sync::Arc;

pub(crate) use rough::Rough;

use super::Distance;
use super::nearest::Watch;
use super::octree::{BuildError, DistanceObject, Settings};
use crate::field::{Aabb, Field};

/// All methods that have a name; the first is the usual one.
pub static METHODS: [&dyn Method; 1] = [&closest_point::ClosestPoint];

/// What to measure.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// What the distance is to: its zero set.
    pub field: &'a dyn Field,
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
    /// The same, where it can be kept as bytes.
    pub object: Option<Arc<DistanceObject>>,
}

impl Measured {
    /// What a distance object tells.
    pub fn of(object: DistanceObject) -> Self {
        let object = Arc::new(object);
        Self { bytes: object.report().bytes as u64, distance: Arc::clone(&object) as _, object: Some(object) }
    }
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
}

/// The method of a name.
pub fn named(name: &str) -> Option<&'static dyn Method> {
    METHODS.into_iter().find(|method| method.name() == name)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use glam::DVec3;

    use super::*;
    use crate::distance::accuracy::exact;
    use crate::distance::testing::{Joined, Leaf};

    /// Each method measures what is no distance itself.
    #[test]
    fn every_method_measures_a_ring() {
        let field = Joined::one(Leaf::Torus(0.7, 0.25));
        let (voxel, solid) = (0.03, Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0)));
        let request = Request { field: &field, solid, detail: voxel, settings: Settings::new(solid, voxel) };
        for (row, method) in METHODS.into_iter().enumerate() {
            let name = method.name();
            assert!(METHODS[..row].iter().all(|other| other.name() != name), "{name} stands twice");
            let found = named(name).expect("it has a name");
            let cancel = AtomicBool::new(false);
            let watch = Watch { cancel: &cancel, progress: &|_| {} };
            let Measured { distance, bytes, .. } = found.measure(&request, &watch).expect("a ring");
            assert!(bytes > 0);
            for place in 0..200 {
                let p = DVec3::from([1, 6, 36].map(|step| f64::from(place / step % 6) * 0.37 - 0.95));
                let (value, truth) = (distance.reference(p), exact::torus(p, 0.7, 0.25));
                assert!((value - truth).abs() < 0.2 * truth.abs().max(voxel), "{name} at {p}: {value} for {truth}");
            }
            cancel.store(true, std::sync::atomic::Ordering::Relaxed);
            assert_eq!(found.measure(&request, &watch).err(), Some(BuildError::Cancelled), "{name} goes on");
        }
    }

    /// A rough distance is right to a cell or two of its lattice, and has the sign of F.
    #[test]
    fn a_rough_distance_is_about_right() {
        let field = Joined::one(Leaf::Torus(0.7, 0.25));
        let solid = Aabb::new(DVec3::new(-0.95, -0.95, -0.25), DVec3::new(0.95, 0.95, 0.25));
        let request = Request { field: &field, solid, detail: 0.01, settings: Settings::new(solid, 0.01) };
        let cancel = AtomicBool::new(false);
        let rough = Rough.measure(&request, &Watch { cancel: &cancel, progress: &|_| {} }).expect("a ring").distance;
        let cell = 1.9 / rough::CELLS;
        for place in 0..1000 {
            let p = DVec3::from([1, 10, 100].map(|step| f64::from(place / step % 10) * 0.23 - 1.05));
            let (value, truth) = (rough.reference(p), exact::torus(p, 0.7, 0.25));
            assert!((value - truth).abs() < 1.5 * cell, "{p}: {value} for {truth}");
            assert!(truth.abs() < cell || (value < 0.0) == (truth < 0.0), "{p}: {value} for {truth}");
        }
    }
}
