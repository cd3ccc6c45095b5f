//! A cross.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::flat;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// A cross.
pub const NODE: Spec = Spec {
    key: Key::length("cross", Required, "Cross of two equal bars around the origin: their length."),
    parameters: &[Key::length("arm", Of("cross", 0.3), "Their width.")],
    formula: "the signed distance to it",
    example: "cross = 1.8",
    plane: Plane::Flat,
    build: |build| {
        let (far, arm) = (build.number("cross")? / 2.0, build.number("arm")? / 2.0);
        if arm >= far {
            let problem = format!("`arm` must be less than the length of the bars, {}", 2.0 * far);
            return Err(build.wrong("arm", problem).help("narrower arms, or `rectangle`"));
        }
        let corners = [
            [far, -arm],
            [far, arm],
            [arm, arm],
            [arm, far],
            [-arm, far],
            [-arm, arm],
            [-far, arm],
            [-far, -arm],
            [-arm, -arm],
            [-arm, -far],
            [arm, -far],
            [arm, -arm],
        ];
        Ok(flat(build, Outline::polygon(&corners.map(DVec2::from))))
    },
    ..Spec::PLAIN
};
