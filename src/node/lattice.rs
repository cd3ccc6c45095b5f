//! Lattices of round struts, by the lines in a cube of edge 1 with one corner at the origin.

use glam::DVec3;

use super::argument::{Arguments, Component};
use super::grading::Ends;
use super::octaves::octaves;
use super::spec::{Build, Grading};
use crate::field::{Graph, Joined, Node, Strut, Struts};
use crate::text::key::Absent::Of;
use crate::text::key::{Key, Kind, Limit};
use crate::text::number::formula::Formula;
use crate::text::problem::Problem;

/// A line between two points.
pub type Line = [DVec3; 2];

/// The key of a lattice's radius, a share of its cell where it is left out.
pub const fn radius(cell: &'static str) -> Key {
    let text = "The radius of its struts: a number, or a formula of x, y, z (`\"0.05 + 0.04*z\"`). Where that is 0 or less there is none.";
    Key::new("radius", Kind::OfSpace, Of(cell, 0.08), text).limit(Limit::Positive).unit("units")
}

/// The row's node.
pub fn lattice(build: &mut dyn Build, key: &str, lines: &[Line]) -> Result<Node, Problem> {
    let edge = build.number(key)?;
    of_radius(build, |graph, radius| struts(graph, lines, edge, radius))
}

/// Struts of the row's radius. Where that is a formula r, F is r − d, d the distance to the nearest line: as steep as 1 and the
/// slope of r, so that the surface is where the lines are as far away as r says there.
pub fn of_radius(build: &mut dyn Build, struts: impl FnOnce(&mut Graph, f64) -> Node) -> Result<Node, Problem> {
    let Some(formula) = formula_of(build.arguments()) else {
        let radius = radius_of(build, build.arguments())?;
        return Ok(struts(build.graph(), radius));
    };
    let formula = formula.clone();
    let reading = build.reading(&formula)?;
    let graph = build.graph();
    let (solid, radius) = (struts(graph, 0.0), reading.node(graph));
    Ok(graph.add(solid, radius))
}

/// The row's node that goes over into another one of it.
pub fn graded(
    build: &mut dyn Build,
    grading: &Grading<'_>,
    key: &str,
    lines: &[Line],
) -> Result<Option<Node>, Problem> {
    let Some(radius) = radii(build, grading, key)? else { return Ok(None) };
    octaves(build, grading, key, |build, octave| {
        let radius = radius.at(octave.share) * octave.scale;
        Ok((struts(build.graph(), lines, octave.edge, radius), radius))
    })
}

/// The radius of struts that goes over from one to another; `None` of formulas in cells of one size, whose values are mixed.
pub fn radii(build: &dyn Build, grading: &Grading<'_>, key: &str) -> Result<Option<Ends>, Problem> {
    if [build.arguments(), grading.to].into_iter().any(|arguments| formula_of(arguments).is_some()) {
        if grading.ends(build, key)?.is_same() {
            return Ok(None);
        }
        let problem = format!("`radius` is a formula, and the cells of `{key}` go over from a size to another");
        return Err(build.wrong(key, problem).help("a number at both: it goes over, too"));
    }
    Ok(Some(Ends([radius_of(build, build.arguments())?, radius_of(build, grading.to)?])))
}

fn struts(graph: &mut Graph, lines: &[Line], edge: f64, radius: f64) -> Node {
    let struts: Vec<Strut> = lines.iter().map(|[a, b]| Strut::new(*a * edge, *b * edge, [radius; 2])).collect();
    graph.field(Joined::shared(Struts::periodic(&struts, edge)))
}

/// The radius where it is a formula.
fn formula_of(arguments: &Arguments) -> Option<&Formula> {
    match arguments.component("radius")? {
        Component::Formula(formula) => Some(formula),
        Component::Number(_) => None,
    }
}

/// The radius where it is a number.
fn radius_of(build: &dyn Build, arguments: &Arguments) -> Result<f64, Problem> {
    match arguments.component("radius") {
        Some(Component::Number(number)) => Ok(number.at(build.moment())?),
        _ => build.number_of(arguments, "radius"),
    }
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
