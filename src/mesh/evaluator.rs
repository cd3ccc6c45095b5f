//! Evaluating a mesh in batches: regions bound and prune.
//!
//! The closest triangle and the side never depend on what was asked before, only the time to find them does.

use std::cell::OnceCell;

use glam::DVec3;

use super::batch::Batch;
use super::{MeshDistance, Nearest};
use crate::field::{Aabb, BATCH, Evaluator, Gradients, Hint, Hints, Interval, Points};

/// Planes that still count as branches. Finer meshes are treated as smooth.
const MOST_PLANES: usize = 16;
/// What the approximate winding number may be off by.
const WINDING_ERROR: f64 = 0.05;

/// A plane of the surface: F of its half-space is `offset − normal · position`.
#[derive(Clone, Copy, Debug)]
struct Plane {
    /// Outward unit normal.
    normal: DVec3,
    offset: f64,
}

/// What is known in a region entered.
struct Region {
    bounds: Aabb,
    centre: DVec3,
    /// No point of the region is farther from the surface than this plus its distance to the centre.
    centre_distance: f64,
    centre_inside: bool,
    /// The side all of the region is on.
    inside: Option<bool>,
    planes: OnceCell<Vec<Plane>>,
}

/// A point whose distance and side are known.
#[derive(Clone, Copy)]
struct Known {
    position: DVec3,
    distance: f64,
    inside: bool,
}

/// Evaluates a mesh on one thread.
pub struct MeshEvaluator<'a> {
    mesh: &'a MeshDistance,
    regions: Vec<Region>,
    known: Option<Known>,
    batch: Batch,
    found: Vec<Nearest>,
}

impl<'a> MeshEvaluator<'a> {
    pub(super) fn new(mesh: &'a MeshDistance) -> Self {
        Self { mesh, regions: Vec::new(), known: None, batch: Batch::default(), found: Vec::new() }
    }

    /// The closest points of the mesh to some points.
    pub fn nearest(&mut self, points: &Points) -> &[Nearest] {
        self.batch.nearest(self.mesh, points, &mut self.found);
        &self.found
    }

    /// Calls with each point's number, position, closest point and whether it is inside.
    fn locate(&mut self, points: &Points, mut take: impl FnMut(usize, DVec3, &Nearest, bool)) {
        self.batch.nearest(self.mesh, points, &mut self.found);
        let found = std::mem::take(&mut self.found);
        for (i, nearest) in found.iter().enumerate() {
            let position = points.position(i);
            take(i, position, nearest, self.is_inside(position, nearest));
        }
        self.found = found;
    }

    /// Whether a position is inside, given its closest point.
    fn is_inside(&mut self, position: DVec3, nearest: &Nearest) -> bool {
        let inside = self.regions.last().and_then(|region| region.inside);
        let inside = inside.or_else(|| self.side_of_known(position));
        let inside = inside.unwrap_or_else(|| self.mesh.is_inside(position, nearest));
        self.known = Some(Known { position, distance: nearest.distance_squared.sqrt(), inside });
        inside
    }

    /// The side, when no surface lies between the position and the last one.
    fn side_of_known(&self, position: DVec3) -> Option<bool> {
        let known = self.known.filter(|_| self.mesh.is_closed())?;
        (known.position.distance(position) < known.distance * (1.0 - 1e-9)).then_some(known.inside)
    }

    /// The side all of a region is on, if it is known to be on one.
    fn side(&self, centre: DVec3, reach: f64, distance: f64, inside: bool) -> Option<bool> {
        if distance <= reach * (1.0 + 1e-9) {
            return None;
        }
        if !self.mesh.is_closed() {
            let bounds = self.mesh.mesh().bounding_box();
            let region = Aabb::new(centre - reach, centre + reach);
            let Some(common) = bounds.intersection(region) else { return Some(false) };
            let number = self.mesh.winding_number(centre)?;
            let change = self.mesh.winding_change(centre, reach) + WINDING_ERROR;
            let outside = number < 0.5;
            return ((number - 0.5).abs() > change && (outside || common == region)).then_some(!outside);
        }
        Some(inside)
    }

    fn planes(&self) -> &[Plane] {
        let Some(region) = self.regions.last() else { return &[] };
        region.planes.get_or_init(|| planes(self.mesh, region))
    }
}

/// The distinct planes of the triangles that may meet a region; none when they are too many.
fn planes(mesh: &MeshDistance, region: &Region) -> Vec<Plane> {
    let scale = region.bounds.min.abs().max(region.bounds.max.abs()).max_element();
    let size = region.bounds.size();
    let slack = 1e-9 * scale.max(size.max_element());
    let mut planes: Vec<Plane> = Vec::new();
    let mut too_many = false;
    let meets = |plane: &Plane| {
        let to_centre = plane.normal.dot(region.centre) - plane.offset;
        to_centre.abs() <= plane.normal.abs().dot(size) * 0.5 + slack
    };
    mesh.visit(&region.bounds, slack, |triangle| {
        let normal = mesh.face_normal(triangle);
        let plane = Plane { normal, offset: normal.dot(mesh.mesh().corners(triangle as usize)[0]) };
        let same = |other: &Plane| {
            let from_centre = |p: &Plane| p.normal.dot(region.centre) - p.offset;
            other.normal.dot(normal) > 1.0 - 1e-12 && (from_centre(other) - from_centre(&plane)).abs() <= slack
        };
        if normal != DVec3::ZERO && meets(&plane) && !planes.iter().any(same) {
            planes.push(plane);
        }
        too_many = planes.len() > MOST_PLANES;
        too_many
    });
    if too_many {
        planes.clear();
    }
    planes
}

impl Evaluator for MeshEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        let centre = region.centre();
        let reach = region.size().length() * 0.5;
        let outer = self.regions.last();
        let by_outer = outer.map_or(f64::INFINITY, |r| r.centre_distance + r.centre.distance(centre));
        let by_known = self.known.map_or(f64::INFINITY, |known| known.distance + known.position.distance(centre));
        // The sum of two roots may round below the truth.
        let nearest = self.mesh.nearest_within(centre, by_outer.min(by_known) * (1.0 + 1e-12));
        let centre_inside = self.is_inside(centre, &nearest);
        let distance = nearest.distance_squared.sqrt();
        let outer = self.regions.last().and_then(|outer| outer.inside);
        let inside = outer.or_else(|| self.side(centre, reach, distance, centre_inside));
        let planes = OnceCell::new();
        self.regions.push(Region { bounds: *region, centre, centre_distance: distance, centre_inside, inside, planes });
    }

    fn bounds(&mut self) -> Interval {
        let Some(region) = self.regions.last() else { return Interval::ALL };
        let &Region { bounds, centre_distance: distance, centre_inside, inside, .. } = region;
        let reach = bounds.size().length() * 0.5;
        // The distance changes by no more than the way walked.
        let farthest = (distance + reach) * (1.0 + 1e-9);
        let least = (distance - reach - 1e-9 * farthest).max(0.0);
        match inside {
            Some(true) => Interval::new(least, farthest),
            Some(false) => Interval::new(-farthest, -least),
            None if !self.mesh.is_closed() => Interval::new(-farthest, farthest),
            None => {
                let signed = if centre_inside { distance } else { -distance };
                let reach = reach + 1e-9 * farthest;
                Interval::new(signed - reach, signed + reach)
            }
        }
    }

    fn hints(&mut self, _: Hint) -> Hints {
        Hints::NONE
    }

    fn leave(&mut self) {
        self.regions.pop();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        self.locate(points, |i, _, nearest, inside| {
            let distance = nearest.distance_squared.sqrt() as f32;
            out[i] = if inside { distance } else { -distance };
        });
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        let mesh = self.mesh;
        self.locate(points, |i, position, nearest, inside| {
            let foot = mesh.foot_of(position, nearest, inside);
            out.set(i, (foot.distance, foot.gradient));
        });
    }

    fn branches(&self) -> usize {
        self.planes().len().max(1)
    }

    fn branch(&mut self, branch: usize, points: &Points, out: &mut Gradients) {
        match self.planes().get(branch).copied() {
            Some(plane) => {
                for i in 0..points.len {
                    out.set(i, (plane.offset - plane.normal.dot(points.position(i)), -plane.normal));
                }
            }
            None => self.gradients(points, out),
        }
    }
}
