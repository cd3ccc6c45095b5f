//! Material with round pores.

use glam::DVec3;

use crate::field::{Balls, Joined, Procedure, Seeds, Slope};
use crate::node::keys::seed;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Of, Required};
use crate::text::key::{Key, Kind, Limit};

/// Material with round pores.
pub const NODE: Spec = Spec {
    key: Key::length(
        "pores",
        Required,
        "Material with a round pore in each cube of a lattice: the cubes' edge. Unbounded: cut it with `bounds`, \
         `intersection`, or as what a shape is filled with.",
    ),
    parameters: &[
        Key::length("radius", Of("pores", 0.4), "The radius of the pores; those that overlap are one."),
        JITTER,
        seed("The number that their places start from."),
    ],
    formula: "|p − c| − r, c the nearest pore's middle",
    example: "pores = 0.5\nbounds = { box = 1.5, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| {
        let (edge, radius) = (grading.ends(build, "pores")?, grading.ends(build, "radius")?);
        let cells = grading.cells(build, "pores", edge)?;
        let balls = cells.into_iter().map(|cell| (cell.at, radius.at(cell.share))).collect();
        let graph = build.graph();
        let pores = graph.field(Joined::shared(Balls::new(balls)));
        Ok(Some(graph.neg(pores)))
    }),
    build: |build| {
        let (edge, radius) = (build.number("pores")?, build.number("radius")?);
        let jitter = build.constant("jitter");
        let seeds = Seeds { edge, jitter, seed: *build.arguments().seed("seed").expect("it has a default") };
        let at = move |p: DVec3| {
            let (value, slope) = seeds.to_nearest(p);
            (-radius - value, -slope)
        };
        // Within a pore, what is next to another one is farther from material than its own ball's surface.
        let slope = Slope::Exact { outside: false, inside: true };
        let material = Procedure { at, bounds: None, slope, is_flat: false };
        Ok(build.graph().field(Joined::shared(material)))
    },
    ..Spec::PLAIN
};

/// How far seeds stray.
pub(crate) const JITTER: Key = Key::new(
    "jitter",
    Kind::Constant,
    Number(0.6),
    "How far a middle is from that of its cube at most along each axis, as a share of half the edge: 0 is a lattice.",
)
.limit(Limit::Within(0.0, 1.0));
