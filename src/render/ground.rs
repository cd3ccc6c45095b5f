//! The ground's light: it is smooth, and so a few points of it tell all.

use glam::DVec2;
use rayon::prelude::*;

use super::{camera::Camera, picture::draws, studio::Studio, trace::Ray};

/// Points each way over which light is smoothed, each with directions of its own.
const WINDOW: usize = 4;
/// Directions that a point looks into for each of the lights.
const DRAWS: usize = 2;

/// How bright the ground is in a picture, as a share of the open ground.
pub(super) struct Ground {
    /// Pixels from point to point.
    step: f32,
    /// Points in a row.
    across: usize,
    light: Vec<f32>,
}

impl Ground {
    /// Looks for the lights from points every so many pixels of a picture. `plane` is the ground's height in voxels.
    pub(super) fn new(studio: &Studio<'_>, camera: &Camera, plane: f64, size: [usize; 2], step: usize) -> Self {
        // One more at the end of each side to interpolate to, and the rest of a window to smooth with.
        let [across, down] = size.map(|pixels| pixels.div_ceil(step) + WINDOW);
        let draws = draws(WINDOW * WINDOW, DRAWS);
        let point = |index: usize| {
            let (column, row) = (index % across, index / across);
            // Half a window back: smoothing brings it forward again.
            let place = (DVec2::new(column as f64, row as f64) - (WINDOW - 1) as f64 / 2.0) * step as f64;
            let size = DVec2::new(size[0] as f64, size[1] as f64);
            let place = place / size * 2.0 - 1.0;
            let ray = Ray::new(camera.eye / studio.voxel_size(), camera.direction(DVec2::new(place.x, -place.y)));
            let phase = row % WINDOW * WINDOW + column % WINDOW;
            ray.meets_level(camera.upright, plane)
                .map_or(1.0, |t| studio.ground(ray.at(t), &draws[phase * DRAWS..][..DRAWS]))
        };
        let raw: Vec<f32> = (0..across * down).into_par_iter().map(point).collect();
        let value = |column: usize, row: usize| raw[row.min(down - 1) * across + column.min(across - 1)];
        let smooth = |index: usize| {
            let (column, row) = (index % across, index / across);
            let window = (0..WINDOW * WINDOW).map(|at| value(column + at % WINDOW, row + at / WINDOW));
            let sum: f32 = window.sum();
            sum / (WINDOW * WINDOW) as f32
        };
        let light = (0..across * down).map(smooth).collect();
        Self { step: step as f32, across, light }
    }

    /// The light at the middle of a pixel.
    pub(super) fn light(&self, column: usize, row: usize) -> f32 {
        let (x, y) = ((column as f32 + 0.5) / self.step, (row as f32 + 0.5) / self.step);
        let at = y as usize * self.across + x as usize;
        let (right, down) = (x.fract(), y.fract());
        let along = |at: usize| self.light[at] + (self.light[at + 1] - self.light[at]) * right;
        let (above, below) = (along(at), along(at + self.across));
        above + (below - above) * down
    }
}
