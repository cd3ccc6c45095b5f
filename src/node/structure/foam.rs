//! Closed foam.

use std::sync::Arc;

use glam::DVec3;

use crate::field::{Field, Joined, Procedure, Sample, Seeds, Slope, Walls};
use crate::node::grading::Ends;
use crate::node::keys::seed;
use crate::node::spec::Spec;
use crate::node::structure::pores::JITTER;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;
use crate::text::problem::Problem;

/// Closed foam.
pub const NODE: Spec = Spec {
    key: Key::length(
        "foam",
        Required,
        "Closed foam: plane walls between points at random, one in each cube of a lattice: the cubes' edge. Unbounded: cut it \
         with `bounds`, `intersection`, or as what a shape is filled with.",
    ),
    parameters: &[
        Key::length("wall", Of("foam", 0.1), "The thickness of the walls."),
        JITTER,
        seed("The number that the points start from."),
    ],
    formula: "w/2 − min over j of (d_j² − d₁²)/(2·|s_j − s₁|), s₁ the nearest point",
    source: "Voronoi cells; Quilez, Voronoi borders",
    example: "foam = 0.6\nbounds = { box = 1.6, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| {
        let (edge, wall) = (grading.ends(build, "foam")?, grading.ends(build, "wall")?);
        let Ends([from, to]) = edge;
        is_thin(wall.at(0.0), from, |problem| build.wrong("wall", problem))?;
        is_thin(wall.at(1.0), to, |problem| grading.wrong(build, "wall", problem))?;
        let cells = grading.cells(build, "foam", edge)?;
        let walls = Walls::new(cells.into_iter().map(|cell| (cell.at, wall.at(cell.share))).collect());
        let Some(walls) = walls else { return Err(build.wrong("foam", "there are fewer than two cells")) };
        Ok(Some(build.graph().field(foam(move |p| walls.at(p)))))
    }),
    build: |build| {
        let (edge, wall) = (build.number("foam")?, build.number("wall")?);
        let jitter = build.constant("jitter");
        is_thin(wall, edge, |problem| build.wrong("wall", problem))?;
        let seeds = Seeds { edge, jitter, seed: *build.arguments().seed("seed").expect("it has a default") };
        Ok(build.graph().field(foam(move |p| {
            let (depth, slope) = seeds.depth(p);
            (wall / 2.0 - depth, -slope)
        })))
    },
    ..Spec::PLAIN
};

/// Walls of which the value is known.
fn foam(at: impl Fn(DVec3) -> Sample + Send + Sync + 'static) -> Arc<dyn Field> {
    // Where walls meet the surface is farther away than they are thick.
    Joined::shared(Procedure { at, bounds: None, slope: Slope::Exact { outside: true, inside: false }, is_flat: false })
}

/// Refuses walls that leave nothing hollow.
fn is_thin(wall: f64, edge: f64, wrong: impl Fn(String) -> Problem) -> Result<(), Problem> {
    if wall < edge {
        return Ok(());
    }
    let problem = format!("`wall` must be less than the edge of the cubes, {edge}");
    Err(wrong(problem).help("a thinner wall, or larger cells"))
}
