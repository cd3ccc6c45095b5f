//! Where a ray meets the surface.
//!
//! In a cell of eight voxels the trilinearly interpolated distance along a straight line is a cubic; its first
//! root is found by parting the cubic at its extrema. So no piece of the interpolated solid is stepped over,
//! however thin. Parts of blocks without a voxel inside are left in one step.

use glam::{DVec3, IVec3};

use super::camera::Up;
use super::volume::{Content, Volume, interpolate, voxel_below};
use crate::grid::BLOCK_EDGE;

/// How far past a border a ray is set, in voxels, so that it stands in the next cell and not on the border. Much
/// smaller would drown in rounding a million voxels from the origin; what lies in the gap is met at its far side.
const NUDGE: f64 = 1e-5;
/// A ray in index space; the direction has unit length, so that `t` counts voxels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    pub origin: DVec3,
    pub direction: DVec3,
    inverse: DVec3,
}

impl Ray {
    /// The ray from a position along a unit direction.
    pub(super) fn new(origin: DVec3, direction: DVec3) -> Self {
        // A component of nothing would give 0·∞ in the slab test.
        let safe = |component: f64| if component.abs() < 1e-12 { f64::copysign(1e-12, component) } else { component };
        let inverse = DVec3::new(safe(direction.x), safe(direction.y), safe(direction.z)).recip();
        Self { origin, direction, inverse }
    }

    pub(super) fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// Where the ray comes down on a plane at a height along the axis that points up, from above, if it does.
    pub(super) fn meets_level(&self, upright: Up, height: f64) -> Option<f64> {
        let (origin, direction) = (self.origin[upright.axis()], self.direction[upright.axis()]);
        let t = (height - origin) / direction;
        (direction < 0.0 && t > 0.0).then_some(t)
    }

    /// Where the ray enters and leaves a box; nowhere if it enters after it leaves.
    pub(super) fn span(&self, min: DVec3, max: DVec3) -> (f64, f64) {
        let (low, high) = ((min - self.origin) * self.inverse, (max - self.origin) * self.inverse);
        (low.min(high).max_element(), low.max(high).min_element())
    }

    fn leaves(&self, origin: IVec3, edge: i32) -> f64 {
        self.span(origin.as_dvec3(), origin.as_dvec3() + f64::from(edge)).1
    }
}

/// The first `t` between `from` and `to` at which the ray is in the solid.
pub(super) fn first_hit(volume: &Volume<'_>, ray: &Ray, from: f64, to: f64) -> Option<f64> {
    let (min, max) = volume.extent();
    let (enter, leave) = ray.span(min, max);
    let end = to.min(leave);
    let mut t = from.max(enter);
    while t < end {
        let cell = volume.cell(voxel_below(ray.at(t)));
        let exit = match cell.content {
            Content::Inside => return Some(t),
            Content::Outside if cell.edge >= super::volume::ROOT_EDGE => next_root(volume, ray, t)?,
            Content::Outside => ray.leaves(cell.origin, cell.edge),
            Content::Block(block) => {
                let exit = ray.leaves(cell.origin, BLOCK_EDGE);
                if !volume.is_hollow(block)
                    && let Some(hit) = hit_in_block(volume, ray, block, cell.origin, t, exit.min(end))
                {
                    return Some(hit);
                }
                exit
            }
        };
        t = exit.max(t) + NUDGE;
    }
    None
}

/// Where the ray enters the nearest root node that still lies ahead.
fn next_root(volume: &Volume<'_>, ray: &Ray, t: f64) -> Option<f64> {
    let entry = |root: &IVec3| {
        let (enter, leave) = ray.span(root.as_dvec3(), root.as_dvec3() + f64::from(super::volume::ROOT_EDGE));
        (enter <= leave && leave > t + NUDGE).then_some(enter)
    };
    volume.roots().iter().filter_map(entry).min_by(f64::total_cmp)
}

fn hit_in_block(volume: &Volume<'_>, ray: &Ray, block: usize, origin: IVec3, from: f64, to: f64) -> Option<f64> {
    let local = Ray { origin: ray.origin - origin.as_dvec3(), ..*ray };
    let mut t = from;
    while t < to {
        let cell = voxel_below(local.at(t)).clamp(IVec3::ZERO, IVec3::splat(BLOCK_EDGE - 1));
        if !volume.may_be_solid(block, cell) {
            t = local.leaves(cell & !1, 2).max(t) + NUDGE;
            continue;
        }
        let corners = volume.corner_values(block, cell);
        let exit = local.leaves(cell, 1).max(t);
        if corners.iter().any(|&corner| corner >= 0.0) {
            let base = cell.as_dvec3();
            let length = exit.min(to) - t;
            let value = |part: f64| interpolate(&corners, local.at(t + length * part) - base);
            if let Some(part) = first_root([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(value)) {
                return Some(t + length * part);
            }
        }
        t = exit + NUDGE;
    }
    None
}

/// The first place in [0, 1] where the cubic through four samples (at 0, 1/3, 2/3 and 1) is not negative.
fn first_root([f0, f1, f2, f3]: [f64; 4]) -> Option<f64> {
    if f0 >= 0.0 {
        return Some(0.0);
    }
    let c1 = -5.5 * f0 + 9.0 * f1 - 4.5 * f2 + f3;
    let c2 = 9.0 * f0 - 22.5 * f1 + 18.0 * f2 - 4.5 * f3;
    let c3 = 4.5 * (f3 - f0 + 3.0 * (f1 - f2));
    let value = |s: f64| ((c3 * s + c2) * s + c1) * s + f0;
    let [early, late] = extrema(c1, c2, c3);
    let mut low = 0.0;
    for high in [early, late, 1.0] {
        if high > low && high <= 1.0 {
            if value(high) >= 0.0 {
                return Some(bisect(value, low, high));
            }
            low = high;
        }
    }
    None
}

/// The roots of c₁ + 2c₂s + 3c₃s², the lesser first; −1 for one that is not there.
fn extrema(c1: f64, c2: f64, c3: f64) -> [f64; 2] {
    let discriminant = c2 * c2 - 3.0 * c1 * c3;
    if discriminant < 0.0 {
        return [-1.0; 2];
    }
    // Without cancellation: q is the larger sum, the other root comes from the product of both.
    let q = -(c2 + f64::copysign(discriminant.sqrt(), c2));
    let root = |over: f64, under: f64| if under == 0.0 { -1.0 } else { over / under };
    let (a, b) = (root(q, 3.0 * c3), root(c1, q));
    if a < b { [a, b] } else { [b, a] }
}

/// The place where a monotone function rises through zero, to 2⁻²⁰ of the interval.
fn bisect(value: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..20 {
        let middle = 0.5 * (low + high);
        if value(middle) >= 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{BLOCK_VOXELS, Band, testing::sphere};

    fn hit(band: &Band, origin: DVec3, direction: DVec3) -> Option<f64> {
        let size = band.lattice.voxel_size.get();
        let ray = Ray::new(origin / size, direction.normalize());
        first_hit(&Volume::new(band), &ray, 0.0, f64::INFINITY).map(|t| t * size)
    }

    #[test]
    fn rays_meet_a_sphere_where_they_should() {
        let (centre, radius, size) = (DVec3::new(0.3, 0.1, -0.2), 1.0, 0.04);
        let band = sphere(centre, radius, size);
        for step in 0..200 {
            let angle = f64::from(step) * 0.7;
            let eye = centre + DVec3::new(libm::cos(angle) * 4.0, libm::sin(angle) * 4.0, libm::cos(angle * 3.0));
            let aim = centre + DVec3::new(0.0, 0.0, f64::from(step % 19) * 0.05);
            let direction = (aim - eye).normalize();
            let along = (centre - eye).dot(direction);
            let across = (centre - eye).length_squared() - along * along;
            let exact = along - (radius * radius - across).sqrt();
            let found = hit(&band, eye, direction).expect("the sphere is in the way");
            assert!((found - exact).abs() < 0.1 * size, "ray {step}: {found} for {exact}");
        }
        assert_eq!(hit(&band, centre + DVec3::new(4.0, 0.0, 1.05), DVec3::NEG_X), None);
    }

    #[test]
    fn a_cubic_with_two_close_roots_is_not_stepped_over() {
        // −(s − 0.40)(s − 0.41)(s + 1) peaks at 3.5e-5 between roots no sampling would see.
        let cubic = |s: f64| -(s - 0.40) * (s - 0.41) * (s + 1.0);
        let root = first_root([cubic(0.0), cubic(1.0 / 3.0), cubic(2.0 / 3.0), cubic(1.0)]).unwrap();
        assert!((root - 0.40).abs() < 1e-5, "{root}");
        assert_eq!(first_root([-1.0, -1.0, -1.0, -1.0]), None);
        assert!((first_root([-1.0, 0.0, 1.0, 2.0]).unwrap() - 1.0 / 3.0).abs() < 1e-5);
    }

    #[test]
    fn nothing_ahead_far_away_or_infinitely_far_apart_ends() {
        let size = 1.0;
        let mut band = sphere(DVec3::ZERO, 20.0, size);
        assert_eq!(hit(&band, DVec3::new(0.0, 100.0, 0.0), DVec3::Y), None);
        // One more block at the far end of all indices: empty space between them is left in one stride.
        let far = IVec3::splat(i32::MAX & !7);
        band.origins.push(far);
        band.distances.push([0.5; BLOCK_VOXELS]);
        band.active.push([u64::MAX; 8]);
        let found = hit(&band, DVec3::splat(100.0), DVec3::ONE).expect("the far block is met");
        let distance = (far.as_dvec3() - 100.0).length();
        assert!((found - distance).abs() < 2.0, "{found} for {distance}");
    }
}
