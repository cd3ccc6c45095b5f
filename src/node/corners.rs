//! The corners of polyhedra around the origin, all as far from it, or scaled so that the farthest are.

use glam::DVec3;

/// (1 + √5)/2, of which pentagons are made.
const GOLDEN: f64 = 1.618_033_988_749_895;

/// All points that the signs of the coordinates give.
fn signed(points: &[[f64; 3]]) -> Vec<DVec3> {
    let mut all: Vec<DVec3> = Vec::new();
    for point in points {
        for i in 0..8 {
            let sign = |bit: usize| if i & bit == 0 { 1.0 } else { -1.0 };
            let corner = DVec3::from(*point) * DVec3::new(sign(1), sign(2), sign(4)) + 0.0;
            if !all.contains(&corner) {
                all.push(corner);
            }
        }
    }
    all
}

/// The same with x, y, z in turns.
fn turned(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    points.iter().flat_map(|&[x, y, z]| [[x, y, z], [y, z, x], [z, x, y]]).collect()
}

/// Scaled so that the farthest is this far from the origin.
fn scaled(points: Vec<DVec3>, radius: f64) -> Vec<DVec3> {
    let far = points.iter().fold(0.0_f64, |far, point| far.max(point.length()));
    points.into_iter().map(|point| point * (radius / far)).collect()
}

/// A corner up.
pub fn tetrahedron(radius: f64) -> Vec<DVec3> {
    let (across, down) = (8.0_f64.sqrt() / 3.0, -1.0 / 3.0);
    let side = 3.0_f64.sqrt() / 2.0;
    [[0.0, 0.0, 1.0], [0.0, across, down], [-across * side, -across / 2.0, down], [across * side, -across / 2.0, down]]
        .map(|corner| DVec3::from(corner) * radius)
        .to_vec()
}

/// On the axes.
pub fn octahedron(radius: f64) -> Vec<DVec3> {
    signed(&turned(&[[radius, 0.0, 0.0]]))
}

/// Twelve pentagons.
pub fn dodecahedron(radius: f64) -> Vec<DVec3> {
    let mut points = turned(&[[0.0, 1.0 / GOLDEN, GOLDEN]]);
    points.push([1.0; 3]);
    scaled(signed(&points), radius)
}

/// Twenty triangles.
pub fn icosahedron(radius: f64) -> Vec<DVec3> {
    scaled(signed(&turned(&[[0.0, 1.0, GOLDEN]])), radius)
}

/// Eight triangles and six squares.
pub fn cuboctahedron(radius: f64) -> Vec<DVec3> {
    scaled(signed(&turned(&[[1.0, 1.0, 0.0]])), radius)
}

/// Eight hexagons and six squares.
pub fn truncated_octahedron(radius: f64) -> Vec<DVec3> {
    scaled(signed(&turned(&[[0.0, 1.0, 2.0], [0.0, 2.0, 1.0]])), radius)
}

/// Twenty hexagons and twelve pentagons.
pub fn truncated_icosahedron(radius: f64) -> Vec<DVec3> {
    let points = [[0.0, 1.0, 3.0 * GOLDEN], [1.0, 2.0 + GOLDEN, 2.0 * GOLDEN], [GOLDEN, 2.0, 2.0 * GOLDEN + 1.0]];
    scaled(signed(&turned(&points)), radius)
}

/// Twelve rhombs.
pub fn rhombic_dodecahedron(radius: f64) -> Vec<DVec3> {
    let mut points = turned(&[[2.0, 0.0, 0.0]]);
    points.push([1.0; 3]);
    scaled(signed(&points), radius)
}
