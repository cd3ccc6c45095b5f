//! A disc cut by a line.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::flat;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Of, Required};
use crate::text::key::{Key, Kind};

/// A disc cut by a line.
pub const NODE: Spec = Spec {
    key: Key::length("cut_disk", Required, "Disc around the origin without what lies above a level line: its radius."),
    parameters: &[Key::new("cut", Kind::Number, Of("cut_disk", 0.4), "The y of the line that cuts it.").unit("units")],
    formula: "the signed distance to it",
    example: "cut_disk = 1",
    plane: Plane::Flat,
    build: |build| {
        let (radius, cut) = (build.number("cut_disk")?, build.number("cut")?);
        if cut.abs() >= radius {
            let problem = format!("`cut` must lie within the disc: between {} and {radius}", -radius);
            return Err(build.wrong("cut", problem).help("`circle` is the whole disc"));
        }
        let right = DVec2::new((radius * radius - cut * cut).sqrt(), cut);
        let left = DVec2::new(-right.x, cut);
        let mut outline = Outline::new();
        outline.line(right).line(left).arc(right, DVec2::ZERO, true).close();
        Ok(flat(build, outline))
    },
    ..Spec::PLAIN
};
