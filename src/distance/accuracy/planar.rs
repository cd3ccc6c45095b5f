//! Outlines made of boxes, L and H, in the plane and extruded, whose exact distance follows from the outline's edges.

use glam::{DVec2, DVec3};

use super::Case;
use super::in_plane::PlaneCase;
use crate::field::{Aabb, Expression, Graph, Node, SetSystem};

/// Half the height of what is extruded.
const HEIGHT: f64 = 0.3;

/// Half the width of all strokes.
const STROKE: f64 = 0.2;

/// Corners of the L, anticlockwise.
const L: [[f64; 2]; 6] = [[-1.0, -1.0], [0.6, -1.0], [0.6, -0.6], [-0.6, -0.6], [-0.6, 1.0], [-1.0, 1.0]];

/// Corners of the H, anticlockwise.
const H: [[f64; 2]; 12] = [
    [-1.0, -1.0],
    [-0.6, -1.0],
    [-0.6, -0.2],
    [0.6, -0.2],
    [0.6, -1.0],
    [1.0, -1.0],
    [1.0, 1.0],
    [0.6, 1.0],
    [0.6, 0.2],
    [-0.6, 0.2],
    [-0.6, 1.0],
    [-1.0, 1.0],
];

/// Both, as unions of boxes under R₀, each the intersection of half-spaces.
pub fn cases() -> [Case; 2] {
    let case = |name, exact, boxes: &[[DVec2; 2]], solid| {
        let mut graph = Graph::new();
        let boxes: Vec<Node> = boxes.iter().map(|&[centre, half]| cuboid(&mut graph, centre, half)).collect();
        let node = graph.union(SetSystem::R0, &boxes);
        Case { name, field: Expression::new(&graph, node), solid, exact }
    };
    let around = |right: f64| Aabb::new(DVec3::new(-1.0, -1.0, -HEIGHT), DVec3::new(right, 1.0, HEIGHT));
    [
        case("L, extruded, boxes under R₀ union", |p| extruded(p, &L), &of_l(), around(0.6)),
        case("H, extruded, boxes under R₀ union", |p| extruded(p, &H), &of_h(), around(1.0)),
    ]
}

/// The same in the plane, and a disc.
pub fn plane_cases() -> [PlaneCase; 3] {
    let case = |name, right, exact, build: &dyn Fn(&mut Graph) -> Node| {
        let mut graph = Graph::new();
        let node = build(&mut graph);
        let shape = Aabb::new(DVec3::new(-1.0, -1.0, 0.0), DVec3::new(right, 1.0, 0.0));
        PlaneCase { name, field: std::sync::Arc::new(Expression::new(&graph, node)), shape, exact }
    };
    let boxes = |graph: &mut Graph, boxes: &[[DVec2; 2]]| {
        let boxes: Vec<Node> = boxes.iter().map(|&[centre, half]| sides(graph, centre, half)).collect();
        graph.union(SetSystem::R0, &boxes)
    };
    [
        case("disc in the plane, r² − |p|²", 1.0, |p| 1.0 - p.length(), &|graph| {
            let squares = [graph.x(), graph.y()].map(|along| graph.square(along));
            let sum = graph.add(squares[0], squares[1]);
            graph.linear(sum, -1.0, 1.0)
        }),
        case("L in the plane, boxes under R₀ union", 0.6, |p| polygon(p, &L), &|graph| boxes(graph, &of_l())),
        case("H in the plane, boxes under R₀ union", 1.0, |p| polygon(p, &H), &|graph| boxes(graph, &of_h())),
    ]
}

/// A stroke from bottom to top.
fn upright(x: f64) -> [DVec2; 2] {
    [DVec2::new(x, 0.0), DVec2::new(STROKE, 1.0)]
}

fn of_l() -> [[DVec2; 2]; 2] {
    [upright(-0.8), [DVec2::new(-0.2, -0.8), DVec2::new(0.8, STROKE)]]
}

fn of_h() -> [[DVec2; 2]; 3] {
    [upright(-0.8), upright(0.8), [DVec2::ZERO, DVec2::new(0.8, STROKE)]]
}

/// A rectangle by four half-spaces under R₀.
fn sides(graph: &mut Graph, centre: DVec2, half: DVec2) -> Node {
    let sides: Vec<Node> = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y]
        .map(|normal| graph.half_space(normal.extend(0.0), half.dot(normal.abs()) + normal.dot(centre)))
        .into();
    graph.intersection(SetSystem::R0, &sides)
}

/// A box by six half-spaces under R₀.
fn cuboid(graph: &mut Graph, centre: DVec2, half: DVec2) -> Node {
    let (centre, half) = (centre.extend(0.0), half.extend(HEIGHT));
    let sides: Vec<Node> = (0..6)
        .map(|side| {
            let normal = DVec3::AXES[side / 2] * if side % 2 == 0 { 1.0 } else { -1.0 };
            graph.half_space(normal, half[side / 2] + normal.dot(centre))
        })
        .collect();
    graph.intersection(SetSystem::R0, &sides)
}

/// The signed distance to an extruded polygon, positive inside.
fn extruded(p: DVec3, corners: &[[f64; 2]]) -> f64 {
    let across = -polygon(DVec2::new(p.x, p.y), corners);
    let along = p.z.abs() - HEIGHT;
    -(across.max(along).min(0.0) + libm::hypot(across.max(0.0), along.max(0.0)))
}

/// The signed distance to a polygon, positive inside: to the nearest edge, with the side by how often it is crossed.
fn polygon(p: DVec2, corners: &[[f64; 2]]) -> f64 {
    let (mut nearest, mut inside) = (f64::INFINITY, false);
    for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let (from, to) = (DVec2::from(*from), DVec2::from(*to));
        let share = ((p - from).dot(to - from) / (to - from).length_squared()).clamp(0.0, 1.0);
        nearest = nearest.min(p.distance(from + share * (to - from)));
        let rises = (from.y > p.y) != (to.y > p.y);
        inside ^= rises && p.x < from.x + (p.y - from.y) / (to.y - from.y) * (to.x - from.x);
    }
    if inside { nearest } else { -nearest }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_extruded_outline_is_exact_at_places_worked_out_by_hand() {
        let (corner, beyond): (f64, f64) = (0.1, 0.5);
        for (p, l, h) in [
            (DVec3::new(-0.8, -0.8, 0.0), 0.2, 0.2),
            (DVec3::new(-0.5, -0.5, 0.0), -corner, -corner),
            (DVec3::new(-0.8, 0.0, 0.25), 0.05, 0.05),
            (DVec3::new(-0.8, 0.0, HEIGHT + beyond), -beyond, -beyond),
            (DVec3::new(0.0, 0.0, 0.0), -0.6, 0.2),
        ] {
            assert!((extruded(p, &L) - l).abs() < 1e-12, "L at {p}: {}", extruded(p, &L));
            assert!((extruded(p, &H) - h).abs() < 1e-12, "H at {p}: {}", extruded(p, &H));
        }
    }
}
