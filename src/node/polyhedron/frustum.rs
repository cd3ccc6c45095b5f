//! A pyramid with its tip cut off.

use glam::DVec3;

use crate::node::profile::{convex, regular};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Of, Required};
use crate::text::key::{Key, Kind, Limit};

/// A pyramid with its tip cut off.
pub const NODE: Spec = Spec {
    key: Key::length(
        "frustum",
        Required,
        "Pyramid along z over a regular polygon with its tip cut off, around the origin: the distance from its axis to the corners of its base.",
    ),
    parameters: &[
        Key::length("top", Of("frustum", 0.5), "The distance from its axis to the corners of its top."),
        Key::new("sides", Kind::Whole, Number(4.0), "How many corners the polygons have.")
            .limit(Limit::Within(3.0, 64.0)),
        Key::length("height", Of("frustum", 1.0), "From its base to its top."),
    ],
    formula: "the signed distance to it",
    example: "frustum = 1",
    build: |build| {
        let (base, top) = (build.number("frustum")?, build.number("top")?);
        let (sides, half) = (build.whole("sides"), build.number("height")? / 2.0);
        let ring = |radius: f64, z: f64| regular(sides, radius).into_iter().map(move |corner| corner.extend(z));
        let corners: Vec<DVec3> = ring(base, -half).chain(ring(top, half)).collect();
        convex(build, "frustum", &corners)
    },
    ..Spec::PLAIN
};
