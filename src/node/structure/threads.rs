//! Woven cloth.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::field::{Joined, Strut, Struts};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// The straight pieces of a thread's wave. Fewer: they stray farther from it, by 0.0006 of a cell with this many.
const PIECES: usize = 32;

/// Woven cloth.
pub const NODE: Spec = Spec {
    key: Key::length(
        "threads",
        Required,
        "Layers of cloth in plain weave, threads along x and y, layers above one another along z: the edge of a cell, which \
         holds two threads each way and one layer. Unbounded: cut it with `bounds` or `intersection`.",
    ),
    parameters: &[
        Key::length("radius", Of("threads", 0.1), "The radius of the threads."),
        Key::length(
            "wave",
            Of("threads", 0.12),
            "How far a thread goes up and down; from `radius` on they touch nowhere.",
        ),
    ],
    formula: "the greatest over the threads of r − |p − q|, q the nearest of the thread's middle, y = ±a/4, z = ±w·sin(2πx/a)",
    example: "threads = 1\nbounds = { box = [3, 3, 0.9], cut = true }",
    is_endless: true,
    build: |build| {
        let (cell, radius, wave) = (build.number("threads")?, build.number("radius")?, build.number("wave")?);
        if radius + wave >= cell / 2.0 {
            let problem = format!("`radius` and `wave` together must be less than half of the cell, {}", cell / 2.0);
            return Err(build.wrong("wave", problem).help("layers would meet: thinner threads, or larger cells"));
        }
        let mut struts = Vec::with_capacity(4 * PIECES);
        for (beside, up) in [(0.25, 1.0), (0.75, -1.0)] {
            let at = |i: usize| {
                let along = i as f64 / PIECES as f64;
                (along * cell, beside * cell, up * wave * libm::sin(TAU * along))
            };
            // Where threads cross, one is above and the other below the layer's middle.
            let warp = |i: usize| {
                let (a, b, up) = at(i);
                DVec3::new(a, b, up)
            };
            let weft = |i: usize| {
                let (a, b, up) = at(i);
                DVec3::new(b, a, -up)
            };
            for i in 0..PIECES {
                struts.push(Strut::new(warp(i), warp(i + 1), [radius; 2]));
                struts.push(Strut::new(weft(i), weft(i + 1), [radius; 2]));
            }
        }
        Ok(build.graph().field(Joined::shared(Struts::periodic(&struts, cell))))
    },
    ..Spec::PLAIN
};
