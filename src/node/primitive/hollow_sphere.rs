//! A ball with a hollow in it.

use glam::DVec3;

use crate::field::Aabb;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// A ball with a hollow in it.
pub const NODE: Spec = Spec {
    key: Key::length("hollow_sphere", Required, "Ball around the origin with a hollow in it: its outer radius."),
    parameters: &[Key::length("wall", Of("hollow_sphere", 0.1), "The thickness of its wall.")],
    formula: "min(r − |p|, |p| − r + w)",
    example: "hollow_sphere = 1\nwall = 0.15\nbounds = { box = [[-1, 0, -1], [1, 1, 1]], cut = true }",
    build: |build| {
        let (radius, wall) = (build.number("hollow_sphere")?, build.number("wall")?);
        if wall >= radius {
            let problem = format!("`wall` must be less than the radius, {radius}");
            return Err(build.wrong("wall", problem).help("a thinner wall, or `sphere`"));
        }
        let graph = build.graph();
        let (outer, inner) = (graph.sphere(radius), graph.sphere(radius - wall));
        let inner = graph.neg(inner);
        let node = graph.min(outer, inner);
        Ok(graph.exact(node, Aabb::new(DVec3::splat(-radius), DVec3::splat(radius))))
    },
    ..Spec::PLAIN
};
