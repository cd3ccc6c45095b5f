//! Meshes whose distance is known, for tests.

use std::f64::consts::PI;

use glam::DVec3;

use super::TriangleMesh;

/// A cube from −half to half on each axis, each face cut into `cuts`² squares.
pub(crate) fn cube(half: f64, cuts: u32) -> TriangleMesh {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let first = positions.len() as u32;
            for i in 0..=cuts {
                for j in 0..=cuts {
                    let along = |k: u32| 2.0 * f64::from(k) / f64::from(cuts) - 1.0;
                    let mut p = [0.0; 3];
                    p[axis] = side;
                    p[(axis + 1) % 3] = along(i);
                    p[(axis + 2) % 3] = along(j);
                    positions.push(DVec3::from(p) * half);
                }
            }
            let at = |i: u32, j: u32| first + i * (cuts + 1) + j;
            for i in 0..cuts {
                for j in 0..cuts {
                    let mut two =
                        [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
                    if side < 0.0 {
                        two.iter_mut().for_each(|t| t.swap(1, 2));
                    }
                    triangles.extend(two);
                }
            }
        }
    }
    TriangleMesh::new(positions, triangles, None).unwrap()
}

/// A ball of rings and segments, with some poles where many triangles meet.
pub(crate) fn ball(centre: DVec3, radius: f64, rings: u32) -> TriangleMesh {
    let segments = rings * 2;
    let mut positions = vec![DVec3::Z, -DVec3::Z];
    for ring in 1..rings {
        for segment in 0..segments {
            let (polar, around) = (PI * f64::from(ring) / f64::from(rings), PI * f64::from(segment) / f64::from(rings));
            let (s, c) = libm::sincos(polar);
            let (sa, ca) = libm::sincos(around);
            positions.push(DVec3::new(s * ca, s * sa, c));
        }
    }
    let at = |ring: u32, segment: u32| 2 + (ring - 1) * segments + segment % segments;
    let mut triangles = Vec::new();
    for segment in 0..segments {
        triangles.push([0, at(1, segment), at(1, segment + 1)]);
        triangles.push([1, at(rings - 1, segment + 1), at(rings - 1, segment)]);
        for ring in 1..rings - 1 {
            let corner = [at(ring, segment), at(ring + 1, segment), at(ring + 1, segment + 1), at(ring, segment + 1)];
            triangles.extend([[corner[0], corner[1], corner[2]], [corner[0], corner[2], corner[3]]]);
        }
    }
    let positions = positions.into_iter().map(|p| p * radius + centre).collect();
    TriangleMesh::new(positions, triangles, None).unwrap()
}

/// Two meshes as one.
pub(crate) fn both(first: &TriangleMesh, second: &TriangleMesh) -> TriangleMesh {
    let shift = first.positions().len() as u32;
    let positions = first.positions().iter().chain(second.positions()).copied().collect();
    let shifted = second.triangles().iter().map(|t| t.map(|v| v + shift));
    TriangleMesh::new(positions, first.triangles().iter().copied().chain(shifted).collect(), None).unwrap()
}

/// The exact signed distance of the cube, positive inside.
pub(crate) fn cube_distance(half: f64, p: DVec3) -> f64 {
    let beyond = p.abs() - half;
    -(beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0))
}
