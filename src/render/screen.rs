//! Which pixels may show the object at all: most of a picture is background, and no ray need be cast there.

use glam::{DVec2, DVec3};

use super::{camera::Camera, volume::Volume};

/// One flag a pixel.
pub(super) struct Screen {
    width: usize,
    flags: Vec<bool>,
}

impl Screen {
    /// Flags every pixel that the box of a solid cell covers, rounded outward.
    pub(super) fn new(volume: &Volume<'_>, camera: &Camera, width: usize, height: usize) -> Self {
        let mut screen = Self { width, flags: vec![false; width * height] };
        let eye = camera.eye / volume.voxel_size();
        let size = DVec2::new(width as f64, height as f64);
        for (origin, edge) in volume.solid_cells() {
            let Some((low, high)) = covered(camera, eye, origin, edge) else {
                // The eye is in or beside the cell.
                screen.flags.fill(true);
                break;
            };
            // In pixels from the top left. Casting to an index saturates at 0.
            let low_pixel = ((low + 1.0) * 0.5 * size - 1.0).floor();
            let high_pixel = ((high + 1.0) * 0.5 * size + 1.0).ceil();
            let columns = low_pixel.x as usize..(high_pixel.x as usize).min(width);
            let rows = low_pixel.y as usize..(high_pixel.y as usize).min(height);
            for row in rows {
                if columns.start < columns.end {
                    screen.flags[row * width..][columns.clone()].fill(true);
                }
            }
        }
        screen
    }

    /// Whether the object may show in a pixel.
    pub(super) fn may_show(&self, column: usize, row: usize) -> bool {
        self.flags[row * self.width + column]
    }
}

/// The least box around a cell in the picture, −1 to 1 from the top left to the bottom right; `None` where a corner
/// is not before the eye.
fn covered(camera: &Camera, eye: DVec3, origin: DVec3, edge: f64) -> Option<(DVec2, DVec2)> {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for corner in 0..8 {
        let step = DVec3::new(f64::from(corner >> 2 & 1), f64::from(corner >> 1 & 1), f64::from(corner & 1));
        let offset = origin + step * edge - eye;
        let depth = offset.dot(camera.forward);
        if depth <= 1.0 {
            return None;
        }
        let place = DVec2::new(offset.dot(camera.right), -offset.dot(camera.up)) / depth / camera.half_extent;
        (low, high) = (low.min(place), high.max(place));
    }
    Some((low, high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        field::Aabb,
        grid::testing::sphere,
        render::{Up, View},
    };

    /// Every pixel that a fine picture of the sphere shows is flagged, and most others are not.
    #[test]
    fn flags_hold_the_object_and_little_else() {
        let (centre, radius) = (DVec3::new(0.2, -0.1, 0.3), 0.6);
        let band = sphere(centre, radius, 0.01);
        let volume = Volume::new(&band);
        let camera = Camera::framing(&Aabb::new(DVec3::NEG_ONE, DVec3::ONE), Up::Z, View::ThreeQuarter, 10.0, 1.5);
        let screen = Screen::new(&volume, &camera, 150, 100);
        let to_centre = centre - camera.eye;
        let (mut shown, mut flagged) = (0, 0);
        for row in 0..100 {
            for column in 0..150 {
                let place = DVec2::new((f64::from(column) + 0.5) / 75.0 - 1.0, 1.0 - (f64::from(row) + 0.5) / 50.0);
                let along = to_centre.dot(camera.direction(place));
                let hit = to_centre.length_squared() - along * along < radius * radius;
                let may_show = screen.may_show(column as usize, row as usize);
                assert!(may_show || !hit, "{column}, {row}");
                shown += usize::from(hit);
                flagged += usize::from(may_show);
            }
        }
        assert!(shown > 1000 && flagged < shown * 2, "{shown} shown, {flagged} flagged");
    }

    #[test]
    fn an_eye_inside_sees_everywhere() {
        let band = sphere(DVec3::ZERO, 1.0, 0.1);
        let camera = Camera::framing(&Aabb::new(DVec3::splat(-0.01), DVec3::splat(0.01)), Up::Z, View::Front, 0.0, 1.0);
        let screen = Screen::new(&Volume::new(&band), &camera, 4, 4);
        assert!((0..16).all(|pixel| screen.may_show(pixel % 4, pixel / 4)));
    }
}
