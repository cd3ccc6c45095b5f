//! Convex hulls of points as meshes.

use glam::DVec3;
use parry3d_f64::transformation::try_convex_hull;

use super::TriangleMesh;

/// The hull of some points; `None` where they all lie in one plane, or nearly so.
pub fn hull(points: &[DVec3]) -> Option<TriangleMesh> {
    let (min, max) = points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
    let size = (max - min).max_element();
    if points.len() < 4 || is_flat(points, 1e-9 * size) {
        return None;
    }
    let given: Vec<_> = points.iter().map(|p| [p.x, p.y, p.z].into()).collect();
    let (corners, triangles) = try_convex_hull(&given).ok()?;
    let corners = corners.iter().map(|corner| DVec3::new(corner.x, corner.y, corner.z)).collect();
    TriangleMesh::new(corners, triangles, None).ok()
}

/// Whether all points are this near to one plane.
fn is_flat(points: &[DVec3], slack: f64) -> bool {
    let from = points[0];
    let farthest = |distance: &dyn Fn(DVec3) -> f64| {
        let best = points.iter().copied().max_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap_or(from);
        (distance(best), best)
    };
    let (length, far) = farthest(&|p| p.distance(from));
    if length <= slack {
        return true;
    }
    let along = (far - from) / length;
    let (width, aside) = farthest(&|p| (p - from).cross(along).length());
    if width <= slack {
        return true;
    }
    let normal = along.cross(aside - from).normalize_or_zero();
    farthest(&|p| normal.dot(p - from).abs()).0 <= slack
}
