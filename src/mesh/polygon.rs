//! Polygons into triangles.

use glam::{DVec2, DVec3};

/// Polygons with more corners than this are fanned: ear clipping takes quadratic time.
const LARGEST_CLIPPED: usize = 2000;

/// Cuts a polygon (corners in order, not necessarily convex or quite flat) into `corners.len() − 2` triangles of
/// indices into `corners`, appended to `out`. Ear clipping in the plane of the polygon's area vector.
pub(super) fn triangulate(corners: &[DVec3], out: &mut Vec<[usize; 3]>) {
    let count = corners.len();
    if count == 3 {
        out.push([0, 1, 2]);
    } else if count > LARGEST_CLIPPED {
        out.extend((2..count).map(|i| [0, i - 1, i]));
    } else if count > 3 {
        clip_ears(&flattened(corners), out);
    }
}

/// The corners seen along the area vector, so that the polygon runs counter-clockwise.
fn flattened(corners: &[DVec3]) -> Vec<DVec2> {
    let doubled_area = |i: usize| (corners[i] - corners[0]).cross(corners[(i + 1) % corners.len()] - corners[0]);
    let normal: DVec3 = (0..corners.len()).map(doubled_area).sum();
    let steepest = normal.abs();
    let project = |p: DVec3| {
        if steepest.x >= steepest.y && steepest.x >= steepest.z {
            if normal.x >= 0.0 { DVec2::new(p.y, p.z) } else { DVec2::new(p.z, p.y) }
        } else if steepest.y >= steepest.z {
            if normal.y >= 0.0 { DVec2::new(p.z, p.x) } else { DVec2::new(p.x, p.z) }
        } else if normal.z >= 0.0 {
            DVec2::new(p.x, p.y)
        } else {
            DVec2::new(p.y, p.x)
        }
    };
    corners.iter().map(|&p| project(p)).collect()
}

fn clip_ears(corners: &[DVec2], out: &mut Vec<[usize; 3]>) {
    let mut left: Vec<usize> = (0..corners.len()).collect();
    while left.len() > 3 {
        let count = left.len();
        let around = |i: usize| [left[(i + count - 1) % count], left[i], left[(i + 1) % count]];
        // A polygon that crosses itself may have no ear: then any corner will do, the count still goes down.
        // Corner 1 first, so that a convex quadrilateral is cut from corner 0, as exporters expect.
        let ear = (1..=count).map(|i| i % count).find(|&i| is_ear(corners, around(i), &left)).unwrap_or(1);
        out.push(around(ear));
        left.remove(ear);
    }
    out.push([left[0], left[1], left[2]]);
}

fn is_ear(corners: &[DVec2], [a, b, c]: [usize; 3], left: &[usize]) -> bool {
    let turn = |p: usize, q: usize, r: usize| (corners[q] - corners[p]).perp_dot(corners[r] - corners[p]);
    let inside = |p: usize| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
    turn(a, b, c) > 0.0 && !left.iter().any(|&p| p != a && p != b && p != c && inside(p))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[DVec3], triangles: &[[usize; 3]]) -> f64 {
        let one = |t: &[usize; 3]| (corners[t[1]] - corners[t[0]]).cross(corners[t[2]] - corners[t[0]]).z / 2.0;
        assert!(triangles.iter().all(|t| one(t) >= 0.0), "a triangle is turned over");
        triangles.iter().map(one).sum()
    }

    #[test]
    fn concave_polygons_keep_their_area() {
        let arrow = [[0.0, 0.0], [2.0, -1.0], [1.0, 0.0], [2.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let comb: Vec<DVec3> = (0..20)
            .map(|i| DVec3::new(f64::from(i), f64::from(i % 2) * 5.0, 0.0))
            .chain([DVec3::new(19.0, 9.0, 0.0), DVec3::new(0.0, 9.0, 0.0)])
            .collect();
        // Shoelace: an independent way to the area.
        let shoelace = |p: &[DVec3]| {
            (0..p.len()).map(|i| p[i].x * p[(i + 1) % p.len()].y - p[(i + 1) % p.len()].x * p[i].y).sum::<f64>() / 2.0
        };
        for polygon in [&arrow[..], &comb[..]] {
            let mut triangles = Vec::new();
            triangulate(polygon, &mut triangles);
            assert_eq!(triangles.len(), polygon.len() - 2);
            assert!((area(polygon, &triangles) - shoelace(polygon)).abs() < 1e-12);
        }
    }
}
