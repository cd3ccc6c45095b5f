//! A triangle.

use crate::field::Outline;
use crate::node::profile::{check_polygon, flat};
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// A triangle.
pub const NODE: Spec = Spec {
    key: Key::new("triangle", Kind::Rows(3, &[2]), Required, "Triangle: its three corners.").unit("units"),
    formula: "the signed distance to it",
    example: "triangle = [[-0.9, -0.6], [0.9, -0.6], [0.3, 0.8]]",
    plane: Plane::Flat,
    build: |build| {
        let corners = build.plane_points("triangle");
        if corners.len() > 3 {
            return Err(build.wrong("triangle", "`triangle` has three corners").help("`polygon` has any number"));
        }
        check_polygon(build, "triangle", &corners)?;
        Ok(flat(build, Outline::polygon(&corners)))
    },
    ..Spec::PLAIN
};
