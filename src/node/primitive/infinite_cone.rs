//! An infinite cone.

use crate::field::Slope;
use crate::node::spec::Spec;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind, Limit};

/// An infinite cone.
pub const NODE: Spec = Spec {
    key: Key::new(
        "infinite_cone",
        Kind::Number,
        Required,
        "Infinite cone with its tip at the origin, which widens towards −z: the angle between its axis and its side. Unbounded; use it to cut.",
    )
    .limit(Limit::Within(0.1, 89.9))
    .unit("degrees"),
    formula: "the signed distance to it",
    example: "infinite_cone = 30\nbounds = 2",
    is_endless: true,
    build: |build| {
        let angle = build.number("infinite_cone")?.to_radians();
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        let graph = build.graph();
        let (across, z, zero) = (graph.radius_about_z(), graph.z(), graph.constant(0.0));
        // The depth below the side, and how far up the side a point lies past the tip.
        let [depth, past] = [(-cos, -sin), (-sin, cos)].map(|(a, b)| {
            let (across, up) = (graph.linear(across, a, 0.0), graph.linear(z, b, 0.0));
            graph.add(across, up)
        });
        let past = graph.max(past, zero);
        let away = graph.length(&[depth, past]);
        let inside = graph.max(depth, zero);
        let inside = graph.linear(inside, 2.0, 0.0);
        let node = graph.sub(inside, away);
        Ok(graph.sloped(node, Slope::Exact { outside: true, inside: true }, None))
    },
    ..Spec::PLAIN
};
