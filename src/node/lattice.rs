//! Lattices of round struts, by the lines in a cube of edge 1 with one corner at the origin.

use glam::DVec3;

use super::argument::{Argument, Component};
use super::spec::Build;
use crate::field::{Joined, Node, Strut, Struts};
use crate::text::key::Absent::Of;
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// A line between two points.
pub type Line = [DVec3; 2];

/// The key of a lattice's radius, a share of its cell where it is left out.
pub const fn radius(cell: &'static str) -> Key {
    let text = "The radius of its struts: a number, or a formula of x, y, z (`\"0.05 + 0.04*z\"`). Where that is 0 or less there is none.";
    Key::new("radius", Kind::OfSpace, Of(cell, 0.08), text).limit(Limit::Positive).unit("units")
}

/// The row's node. Where the radius is a formula r, F is r − d, d the distance to the nearest line: as steep as 1 and the slope
/// of r, so that the surface is where the lines are as far away as r says there.
pub fn lattice(build: &mut dyn Build, key: &str, lines: &[Line]) -> Result<Node, Problem> {
    let edge = build.number(key)?;
    let given = match build.arguments().get("radius") {
        Some(Argument::Components(components)) => components.first().cloned(),
        _ => None,
    };
    let (radius, added) = match given {
        Some(Component::Formula(formula)) => (0.0, Some(build.reading(&formula)?)),
        Some(Component::Number(number)) => (number.at(build.moment())?, None),
        None => (build.number("radius")?, None),
    };
    let struts: Vec<Strut> = lines.iter().map(|[a, b]| Strut::new(*a * edge, *b * edge, [radius; 2])).collect();
    let graph = build.graph();
    let solid = graph.field(Joined::shared(Struts::periodic(&struts, edge)));
    Ok(match added {
        Some(reading) => {
            let radius = reading.node(graph);
            graph.add(solid, radius)
        }
        None => solid,
    })
}

const HALF: f64 = 0.5;

/// The corners and the face centres of the cubes, of each the one next to the origin.
const FACES: [DVec3; 4] =
    [DVec3::ZERO, DVec3::new(HALF, HALF, 0.0), DVec3::new(HALF, 0.0, HALF), DVec3::new(0.0, HALF, HALF)];

/// All eight signs.
fn signs() -> impl Iterator<Item = DVec3> {
    (0..8).map(|i| DVec3::new(f64::from(i / 4 * 2 - 1), f64::from(i / 2 % 2 * 2 - 1), f64::from(i % 2 * 2 - 1)))
}

/// The edges at the origin.
pub fn edges() -> Vec<Line> {
    DVec3::AXES.map(|axis| [DVec3::ZERO, axis]).to_vec()
}

/// From the centre to the corners.
pub fn space_diagonals() -> Vec<Line> {
    signs().map(|sign| [DVec3::splat(HALF), DVec3::splat(HALF) + sign * HALF]).collect()
}

/// Of the three faces at the origin, from the middle to the corners.
pub fn face_diagonals() -> Vec<Line> {
    let of = |centre: DVec3| {
        // Twice each: the sign across the face plays no role.
        signs().map(move |sign| [centre, centre + sign * centre]).filter(|[a, b]| a != b)
    };
    let mut lines: Vec<Line> = Vec::new();
    for line in FACES[1..].iter().flat_map(|centre| of(*centre)) {
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    lines
}

/// Between the middles of faces that meet.
pub fn octahedron() -> Vec<Line> {
    let middles: Vec<DVec3> =
        DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]).map(|way| (DVec3::ONE + way) * HALF).collect();
    between(&middles, HALF.sqrt())
}

/// The lines between points of a distance.
fn between(points: &[DVec3], distance: f64) -> Vec<Line> {
    let pairs = points.iter().enumerate().flat_map(|(i, a)| points[i + 1..].iter().map(move |b| [*a, *b]));
    pairs.filter(|[a, b]| (a.distance(*b) - distance).abs() < 1e-6).collect()
}

/// Around the centre.
pub fn truncated_octahedra() -> Vec<Line> {
    let corners = super::corners::truncated_octahedron(0.3125_f64.sqrt());
    let corners: Vec<DVec3> = corners.into_iter().map(|corner| corner + HALF).collect();
    between(&corners, HALF.sqrt() / 2.0)
}

/// From each atom between the corners and face centres to its four neighbours among these.
pub fn diamond_bonds() -> Vec<Line> {
    FACES.iter().flat_map(|cell| FACES.map(|atom| [*cell + 0.25, *cell + atom])).collect()
}

/// Around the corners and face centres.
pub fn rhombic_dodecahedra() -> Vec<Line> {
    let corners = super::corners::rhombic_dodecahedron(HALF);
    let around = |centre: &DVec3| corners.iter().map(|corner| *corner + *centre).collect::<Vec<_>>();
    FACES.iter().flat_map(|centre| between(&around(centre), 3.0_f64.sqrt() / 4.0)).collect()
}

/// From the centres of the eight eighths to the corners and face centres around.
pub fn fluorite_bonds() -> Vec<Line> {
    let is_site = |corner: &DVec3| (corner.element_sum().round() as i64) % 2 == 0;
    let centres = signs().map(|sign| DVec3::splat(HALF) + sign * 0.25);
    centres
        .flat_map(|centre| signs().map(move |sign| [centre, centre + sign * 0.25]))
        .filter(|[_, end]| is_site(&(*end * 2.0)))
        .collect()
}
