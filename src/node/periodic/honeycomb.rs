//! Walls of hexagonal cells.

use glam::{DVec2, DVec3};

use crate::field::{Joined, Procedure, Slope};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// Walls of hexagonal cells.
pub const NODE: Spec = Spec {
    key: Key::length(
        "honeycomb",
        Required,
        "Walls of hexagonal cells along z: the distance between the middles of opposite walls. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: &[Key::length("wall", Of("honeycomb", 0.1), "The thickness of its walls.")],
    formula: "w/2 minus the distance to the nearest middle of a wall",
    example: "honeycomb = 0.6\nbounds = { box = [2.4, 2.2, 0.8], cut = true }",
    is_endless: true,
    build: |build| {
        let (cell, wall) = (build.number("honeycomb")?, build.number("wall")?);
        if wall >= cell {
            let problem = format!("`wall` must be less than the distance of the walls, {cell}");
            return Err(build.wrong("wall", problem).help("a thinner wall, or larger cells"));
        }
        let at = move |p: DVec3| {
            let (depth, outward) = in_cell(p.truncate(), cell);
            (wall / 2.0 - depth, outward.extend(0.0))
        };
        // Where three walls meet the surface is farther away than they are thick.
        let slope = Slope::Exact { outside: true, inside: false };
        let walls = Procedure { at, bounds: None, slope, is_flat: true };
        Ok(build.graph().field(Joined::shared(walls)))
    },
    ..Spec::PLAIN
};

/// How far a point lies from the nearest side of the hexagon that it is in, and the direction of that side.
fn in_cell(point: DVec2, cell: f64) -> (f64, DVec2) {
    // The middles of hexagons are those of two lattices of rectangles.
    let lattice = DVec2::new(1.0, 3.0_f64.sqrt()) * cell;
    let from = |shift: DVec2| {
        let share = (point - shift) / lattice;
        (share - share.round()) * lattice
    };
    let (first, second) = (from(DVec2::ZERO), from(lattice / 2.0));
    let way = if first.length_squared() <= second.length_squared() { first } else { second };
    let sides = [DVec2::X, DVec2::new(0.5, 0.75_f64.sqrt())];
    let (far, side) = sides
        .map(|side| (side.dot(way.abs()), side))
        .into_iter()
        .reduce(|a, b| if a.0 >= b.0 { a } else { b })
        .expect("there are two");
    (cell / 2.0 - far, DVec2::new(side.x.copysign(way.x), side.y.copysign(way.y)))
}
