//! A rhombus.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::flat;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind, Limit};

/// A rhombus.
pub const NODE: Spec = Spec {
    key: Key::new("rhombus", Kind::Pair, Required, "Rhombus around the origin: its diagonals along x and y.")
        .limit(Limit::Positive)
        .unit("units"),
    formula: "the signed distance to it",
    example: "rhombus = [1.8, 1.1]",
    plane: Plane::Flat,
    build: |build| {
        let half = build.pair("rhombus")? / 2.0;
        let corners = [[half.x, 0.0], [0.0, half.y], [-half.x, 0.0], [0.0, -half.y]].map(DVec2::from);
        Ok(flat(build, Outline::polygon(&corners)))
    },
    ..Spec::PLAIN
};
