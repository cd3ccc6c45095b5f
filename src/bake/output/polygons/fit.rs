//! The point that lies on several planes as well as any, as dual contouring asks for (Ju et al. 2002).

use glam::{DMat3, DVec3};

use crate::field::eigen;

/// Directions in which the planes say less than this share of what they say in the clearest one do not count: along them
/// the point stays at the planes' middle.
const UNCLEAR: f64 = 0.05;

/// The point nearest to the middle of some points among those that fit planes through them best.
pub fn point_on(planes: &[(DVec3, DVec3)]) -> DVec3 {
    let middle = planes.iter().map(|(point, _)| *point).sum::<DVec3>() / planes.len().max(1) as f64;
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for (point, normal) in planes {
        let offset = normal.dot(*point - middle);
        right += *normal * offset;
        matrix += DMat3::from_cols(*normal * normal.x, *normal * normal.y, *normal * normal.z);
    }
    let (values, vectors) = eigen(matrix);
    let least = UNCLEAR * values.max_element();
    let mut shift = DVec3::ZERO;
    for i in 0..3 {
        if values[i] > least && values[i] > 0.0 {
            let direction = vectors.col(i);
            shift += direction * (direction.dot(right) / values[i]);
        }
    }
    middle + shift
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_edges_and_planes() {
        let corner = DVec3::new(0.2, -0.3, 0.7);
        let plane = |normal: DVec3, along: DVec3| {
            let normal = normal.normalize();
            (corner + along - normal * normal.dot(along), normal)
        };
        let (a, b, c) = (DVec3::new(1.0, 0.2, 0.1), DVec3::new(-0.3, 1.0, 0.2), DVec3::new(0.1, -0.4, 1.0));
        let three = [plane(a, b), plane(b, c), plane(c, a), plane(a, c)];
        assert!(point_on(&three).distance(corner) < 1e-12, "{}", point_on(&three));
        // Two planes: on both, and no further along their edge than the middle of what was given.
        let two = [plane(a, c), plane(b, c)];
        let found = point_on(&two);
        assert!(two.iter().all(|(point, normal)| normal.dot(found - *point).abs() < 1e-12));
        let edge = two[0].1.cross(two[1].1).normalize();
        assert!(edge.dot(found - (two[0].0 + two[1].0) / 2.0).abs() < 1e-12);
        // One plane: the middle itself.
        let one = [(DVec3::X, DVec3::Z), (DVec3::Y, DVec3::Z)];
        assert!(point_on(&one).distance(DVec3::new(0.5, 0.5, 0.0)) < 1e-12);
    }
}
