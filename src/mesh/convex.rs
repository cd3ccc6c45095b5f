//! Convex meshes of few faces as half-spaces: an operand that costs a handful of multiplications a point instead of
//! a search for the closest triangle.

use glam::DVec3;

use super::TriangleMesh;

/// More planes than this are slower than the search, and are left to it.
const MOST_PLANES: usize = 32;

/// The outward unit normals n and offsets o of half-spaces n · p ≤ o whose intersection is the mesh's inside; `None`
/// where it is not convex, faces inward, or has too many faces.
pub(super) fn half_spaces(mesh: &TriangleMesh) -> Option<Vec<(DVec3, f64)>> {
    let slack = 1e-9 * mesh.bounding_box().size().max_element();
    let mut planes: Vec<(DVec3, f64)> = Vec::new();
    for triangle in 0..mesh.triangles().len() {
        let [a, b, c] = mesh.corners(triangle);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        if normal == DVec3::ZERO {
            continue;
        }
        let offset = normal.dot(a);
        let same = |plane: &(DVec3, f64)| plane.0.dot(normal) > 1.0 - 1e-12 && (plane.1 - offset).abs() <= slack;
        if planes.iter().any(same) {
            continue;
        }
        if planes.len() == MOST_PLANES || mesh.positions().iter().any(|p| normal.dot(*p) > offset + slack) {
            return None;
        }
        planes.push((normal, offset));
    }
    // Fewer cannot bound a solid.
    (planes.len() >= 4).then_some(planes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pyramid over a square whose tip stands at a height.
    fn pyramid(tip: f64) -> TriangleMesh {
        let corner = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let positions =
            vec![corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0), DVec3::Z * tip];
        let triangles = vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [0, 2, 1], [0, 3, 2]];
        TriangleMesh::new(positions, triangles, None).expect("a mesh")
    }

    #[test]
    fn a_pyramid_is_five_half_spaces() {
        let planes = half_spaces(&pyramid(2.0)).expect("convex");
        assert_eq!(planes.len(), 5);
        let inside = |p: DVec3| planes.iter().all(|(normal, offset)| normal.dot(p) <= *offset);
        // At half height the section is a square of half edge ½.
        for (x, is_inside) in [(0.49, true), (0.51, false), (-0.49, true), (-0.51, false)] {
            assert_eq!(inside(DVec3::new(x, 0.0, 1.0)), is_inside, "{x}");
        }
        assert!(!inside(DVec3::new(0.0, 0.0, -0.01)) && inside(DVec3::new(0.0, 0.0, 0.01)));
    }

    #[test]
    fn a_dent_or_an_inward_face_is_not_convex() {
        let dented = {
            // The base pushed in: its four triangles meet at a point above it.
            let mesh = pyramid(2.0);
            let mut positions = mesh.positions().to_vec();
            positions.push(DVec3::Z * 0.5);
            let triangles =
                vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5]];
            TriangleMesh::new(positions, triangles, None).expect("a mesh")
        };
        assert!(half_spaces(&dented).is_none());
        assert!(half_spaces(&pyramid(-2.0)).is_none());
    }
}
