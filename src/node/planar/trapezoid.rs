//! A trapezoid.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::flat;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// A trapezoid.
pub const NODE: Spec = Spec {
    key: Key::length("trapezoid", Required, "Symmetric trapezoid around the origin: the length of its lower edge."),
    parameters: &[
        Key::length("top", Of("trapezoid", 0.5), "The length of its upper edge."),
        Key::length("height", Of("trapezoid", 0.6), "Between these edges."),
    ],
    formula: "the signed distance to it",
    example: "trapezoid = 1.6",
    plane: Plane::Flat,
    build: |build| {
        let (base, top) = (build.number("trapezoid")? / 2.0, build.number("top")? / 2.0);
        let up = build.number("height")? / 2.0;
        let corners = [[-base, -up], [base, -up], [top, up], [-top, up]].map(DVec2::from);
        Ok(flat(build, Outline::polygon(&corners)))
    },
    ..Spec::PLAIN
};
