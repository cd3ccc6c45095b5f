//! How the signed distance to a field's zero set is measured: one method, one file here and one row of [`METHODS`].

mod closest_point;

use std::sync::Arc;

use super::Distance;
use super::nearest::Watch;
use super::octree::{BuildError, Settings};
use crate::field::{Aabb, Field};

/// All methods; the first is the usual one.
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
            let Measured { distance, bytes } = found.measure(&request, &watch).expect("a ring");
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
}
