//! How right distances in the plane are, at the centres of pixels beside the outline.

use std::sync::Arc;
use std::time::Instant;

use glam::{DVec2, DVec3};

use super::table::{HALF_WIDTH, Level};
use crate::distance::method::{Method, Request};
use crate::distance::nearest::Watch;
use crate::distance::octree::{BuildError, Settings};
use crate::field::{Aabb, BATCH, Field, Gradients, Points};

/// A shape of the plane whose distance is known in closed form, written as a function that is not a distance.
pub struct PlaneCase {
    /// What it is.
    pub name: &'static str,
    /// The function.
    pub field: Arc<dyn Field>,
    /// Its box, of no height.
    pub shape: Aabb,
    /// The exact signed distance, positive inside.
    pub exact: fn(DVec2) -> f64,
}

/// The errors of a method on a shape at so many pixels along its longest side.
///
/// # Errors
/// Those of the method; [`BuildError::SolidsOnly`] of one that does not measure shapes of the plane.
pub fn judge(case: &PlaneCase, method: &dyn Method, resolution: u32, watch: &Watch<'_>) -> Result<Level, BuildError> {
    let pixel = case.shape.size().max_element() / f64::from(resolution);
    // As slices have them.
    let settings = Settings { tolerance: 0.02 * pixel, ..Settings::new(case.shape, 0.25 * pixel) };
    let request = Request { field: &case.field, solid: case.shape, detail: pixel, settings };
    let start = Instant::now();
    let distance = method.measure_in_plane(&request, watch)?.distance;
    let seconds = start.elapsed().as_secs_f64();
    let reach = f64::from(HALF_WIDTH) * pixel;
    let least = case.shape.min - reach;
    let count = ((case.shape.size() + 2.0 * reach) / pixel).ceil();
    let middle = |place: u64| {
        let along = count.x as u64;
        // Off the corners of cells, which are right by themselves.
        least + (DVec3::new((place % along) as f64, (place / along) as f64, 0.0) + 0.37) * pixel
    };
    let near: Vec<DVec3> = (0..count.x as u64 * count.y as u64)
        .map(|place| middle(place).with_z(0.0))
        .filter(|at| (case.exact)(at.truncate()).abs() < reach)
        .collect();
    let mut evaluator = distance.evaluator();
    let mut found = Gradients::new();
    let mut level =
        Level { resolution, voxels: near.len() as u64, mean: 0.0, max: 0.0, slope: 0.0, wrong_signs: 0, seconds };
    for chunk in near.chunks(BATCH) {
        evaluator.gradients(&Points::of_positions(chunk), &mut found);
        for (i, at) in chunk.iter().enumerate() {
            let (value, truth) = (f64::from(found.value[i]), (case.exact)(at.truncate()));
            let error = (value - truth).abs() / pixel;
            level.mean += error / near.len() as f64;
            level.max = level.max.max(error);
            level.slope += (f64::from(found.gradient(i).length()) - 1.0).abs() / near.len() as f64;
            level.wrong_signs += u64::from(truth.abs() > 1e-4 * pixel && (truth > 0.0) != (value > 0.0));
        }
    }
    Ok(level)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::distance::accuracy::planar::plane_cases;
    use crate::distance::method::{METHODS, named};

    /// The mean is that of bands. Between corners, cells across a crease round it at an eighth of the way to the outline. The side
    /// of `adf` is F's own everywhere.
    #[test]
    fn methods_are_as_right_as_in_space() {
        let cancel = AtomicBool::new(false);
        let watch = Watch { cancel: &cancel, progress: &|_| {} };
        for case in plane_cases() {
            for name in ["closest-point", "adf"] {
                let level = judge(&case, named(name), 64, &watch).expect("an outline");
                assert!(
                    level.mean < 0.005 && level.max < 0.15 && level.slope < 0.05,
                    "{} by {name}: {level:?}",
                    case.name
                );
                assert!(level.voxels > 500 && (name != "adf" || level.wrong_signs == 0), "{level:?}");
            }
            for method in METHODS.into_iter().filter(|method| ["vector-dt", "fim"].contains(&method.name())) {
                let refused = judge(&case, method, 64, &watch).err();
                assert_eq!(refused, Some(BuildError::SolidsOnly { method: method.name() }));
            }
        }
    }
}
