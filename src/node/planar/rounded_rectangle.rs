//! A rectangle with round corners.

use crate::node::planar::rectangle::rectangle;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A rectangle with round corners.
pub const NODE: Spec = Spec {
    key: Key::new(
        "rounded_rectangle",
        Kind::Pair,
        Required,
        "Rectangle around the origin with round corners: its edge lengths; one number is a square.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    parameters: &[Key::length("corner_radius", Number(0.2), "The radius of its corners.")],
    formula: "the signed distance to it",
    example: "rounded_rectangle = [1.6, 1]",
    plane: Plane::Flat,
    build: |build| {
        let (edges, radius) = (build.pair("rounded_rectangle")?, build.number("corner_radius")?);
        if 2.0 * radius > edges.min_element() {
            let most = edges.min_element() / 2.0;
            let problem = format!("`corner_radius` is more than half of the shorter edge, {most}");
            return Err(build.wrong("corner_radius", problem).help("a smaller radius, or longer edges"));
        }
        Ok(rectangle(build.graph(), edges, radius))
    },
    ..Spec::PLAIN
};
