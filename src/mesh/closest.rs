//! The closest point of one triangle, and which part of the triangle it lies on.

use glam::DVec3;

/// Which part of a triangle: the face, side `i` (from corner `i` to the next), or corner `i`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Its inside.
    Face,
    /// The side from a corner to the next.
    Side(u8),
    /// A corner.
    Corner(u8),
}

/// The closest point of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closest {
    pub point: DVec3,
    /// Weights of the second and third corner.
    pub weights: [f64; 2],
    pub part: Part,
}

/// The point of a triangle that is closest to `p`, by the Voronoi regions of its corners and sides (C. Ericson,
/// Real-Time Collision Detection, 5.1.5).
pub(super) fn closest([a, b, c]: [DVec3; 3], p: DVec3) -> Closest {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let at = |v: f64, w: f64, part| Closest { point: a + ab * v + ac * w, weights: [v, w], part };
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return Closest { point: a, weights: [0.0, 0.0], part: Part::Corner(0) };
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return Closest { point: b, weights: [1.0, 0.0], part: Part::Corner(1) };
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return at(d1 / (d1 - d3), 0.0, Part::Side(0));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return Closest { point: c, weights: [0.0, 1.0], part: Part::Corner(2) };
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return at(0.0, d2 / (d2 - d6), Part::Side(2));
    }
    let va = d3 * d6 - d5 * d4;
    let (along, back) = (d4 - d3, d5 - d6);
    if va <= 0.0 && along >= 0.0 && back >= 0.0 {
        let w = along / (along + back);
        return Closest { point: b + (c - b) * w, weights: [1.0 - w, w], part: Part::Side(1) };
    }
    let scale = 1.0 / (va + vb + vc);
    at(vb * scale, vc * scale, Part::Face)
}

/// The same for a triangle without an area, where the regions above divide by zero: the closest of its sides.
pub(super) fn closest_of_sides(corners: [DVec3; 3], p: DVec3) -> Closest {
    let side = |i: usize| {
        let (from, to) = (corners[i], corners[(i + 1) % 3]);
        let along = to - from;
        let length_squared = along.length_squared();
        let w = if length_squared > 0.0 { ((p - from).dot(along) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
        let weights = match i {
            0 => [w, 0.0],
            1 => [1.0 - w, w],
            _ => [0.0, 1.0 - w],
        };
        Closest { point: from + along * w, weights, part: Part::Side(i as u8) }
    };
    let nearer = |one: Closest, other: Closest| {
        if other.point.distance_squared(p) < one.point.distance_squared(p) { other } else { one }
    };
    nearer(nearer(side(0), side(1)), side(2))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn position() -> impl Strategy<Value = DVec3> {
        [-2.0..2.0, -2.0..2.0, -2.0..2.0].prop_map(|p: [f64; 3]| DVec3::from(p))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// The optimality conditions of a projection onto a convex set, which know nothing of regions.
        #[test]
        fn is_the_projection(corners in [position(), position(), position()], p in position()) {
            for closest in [closest(corners, p), closest_of_sides(corners, p)] {
                let [v, w] = closest.weights;
                prop_assert!(v >= -1e-12 && w >= -1e-12 && v + w <= 1.0 + 1e-12);
                let [a, b, c] = corners;
                prop_assert!((a + (b - a) * v + (c - a) * w).distance(closest.point) < 1e-12);
            }
            let foot = closest(corners, p).point;
            for corner in corners {
                prop_assert!((p - foot).dot(corner - foot) < 1e-9);
            }
        }

        #[test]
        fn without_area(a in position(), along in position(), p in position()) {
            let corners = [a, a + along, a + along * 0.3];
            let foot = closest_of_sides(corners, p).point;
            for corner in corners {
                prop_assert!((p - foot).dot(corner - foot) < 1e-9);
            }
        }
    }
}
