//! Copies around an axis.

use glam::DVec3;

use crate::field::{CopyPlace, rotation};
use crate::node::copied::{MOST_COPIES, cells_of, copies_of};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Nothing, Number, Text};
use crate::text::key::{Key, Kind, Limit};

/// Copies around the z axis.
pub const NODE: Spec = Spec {
    key: Key::new("polar", Kind::Whole, Nothing, "So many copies around the z axis, turned with their places.")
        .limit(Limit::Within(1.0, MOST_COPIES as f64)),
    parameters: &[
        Key::new("polar_radius", Kind::Number, Number(0.0), "How far from the axis, along x, the first is moved.")
            .unit("units"),
        Key::new(
            "arc",
            Kind::Number,
            Number(360.0),
            "The angle that they are spread over. Less than a whole turn has a copy at both of its ends.",
        )
        .unit("degrees"),
        Key::new("rise", Kind::Number, Number(0.0), "How much higher each is than the one before it.").unit("units"),
        Key::new("turned", Kind::Choice(&["along", "fixed"]), Text("along"), "Whether copies turn with their places."),
    ],
    formula: "max over i of f(R(−i·a/n)·p − (r, 0, 0))",
    example: "box = [0.45, 0.3, 0.8]\npolar = 9\npolar_radius = 0.8",
    cells: Some(cells_of),
    bend: Some(|build| {
        let count = build.arguments().whole("polar").map_or(1, |count| (*count).max(1) as u32);
        let (radius, arc, rise) = (build.number("polar_radius")?, build.number("arc")?, build.number("rise")?);
        // A whole turn ends where it begins.
        let steps = if arc.abs() < 360.0 { (count - 1).max(1) } else { count };
        let turns = build.arguments().choice("turned") != Some(&"fixed");
        let place = |i: u32| {
            let turn = rotation(DVec3::Z * (arc * f64::from(i) / f64::from(steps)));
            let at = turn * DVec3::X * radius + DVec3::Z * (rise * f64::from(i));
            CopyPlace { turn: if turns { turn } else { glam::DMat3::IDENTITY }, ..CopyPlace::moved(at) }
        };
        copies_of(build, (0..count).map(place).collect())
    }),
    ..Spec::PLAIN
};
