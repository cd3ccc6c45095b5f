//! Closed foam.

use glam::DVec3;

use crate::field::{Joined, Procedure, Seeds, Slope};
use crate::node::keys::seed;
use crate::node::spec::Spec;
use crate::node::structure::pores::JITTER;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

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
    build: |build| {
        let (edge, wall) = (build.number("foam")?, build.number("wall")?);
        let jitter = build.constant("jitter");
        if wall >= edge {
            let problem = format!("`wall` must be less than the edge of the cubes, {edge}");
            return Err(build.wrong("wall", problem).help("a thinner wall, or larger cells"));
        }
        let seeds = Seeds { edge, jitter, seed: *build.arguments().seed("seed").expect("it has a default") };
        let at = move |p: DVec3| {
            let (depth, slope) = seeds.depth(p);
            (wall / 2.0 - depth, -slope)
        };
        // Where walls meet the surface is farther away than they are thick.
        let walls =
            Procedure { at, bounds: None, slope: Slope::Exact { outside: true, inside: false }, is_flat: false };
        Ok(build.graph().field(Joined::shared(walls)))
    },
    ..Spec::PLAIN
};
