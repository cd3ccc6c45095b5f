//! A shape cut off at a box.

use glam::DAffine3;

use crate::field::SetSystem;
use crate::node::spec::Spec;
use crate::text::key::Absent::Nothing;
use crate::text::key::{Key, Kind};
use crate::text::problem::Problem;
use crate::text::source::Span;

/// Cut off outside of a box.
pub const NODE: Spec = Spec {
    key: Key::new(
        "bounds",
        Kind::Box,
        Nothing,
        "Cut off outside of this box, in the shape's own space. A shape without end needs it. Where it cuts a warning says so; `{ box = …, cut = true }` says that it is meant.",
    ),
    example: "half_space = [0, 0, 1]\nbounds = { box = 2, cut = true }",
    build: |build| {
        let aabb = build.arguments().bounds("bounds").expect("it must be there").aabb;
        let node = build.inner()?;
        let graph = build.graph();
        let cuboid = graph.cuboid(aabb.size());
        let placed = DAffine3::from_translation(aabb.centre());
        let cuboid = match placed == DAffine3::IDENTITY {
            true => cuboid,
            false => graph
                .transform(cuboid, &placed)
                .map_err(|error| Problem::new(Span::default(), format!("`bounds`: {error}")))?,
        };
        Ok(graph.intersection(SetSystem::R0, &[node, cuboid]))
    },
    ..Spec::PLAIN
};
