//! Copies in a hexagonal grid.

use glam::DVec3;

use crate::field::CopyPlace;
use crate::node::copied::{cells_of, copies_of};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Nothing, Number};
use crate::text::key::{Key, Kind, Limit};

/// Copies in a hexagonal grid.
pub const NODE: Spec = Spec {
    key: Key::new(
        "hexagonal",
        Kind::Whole,
        Nothing,
        "Copies in a hexagonal grid around z: the one in the middle, and so many rings around it.",
    )
    .limit(Limit::Within(0.0, 1000.0)),
    parameters: &[Key::length("pitch", Number(1.0), "How far each is from its six neighbours.")],
    formula: "max over i, j of f(p − d·(i + j/2, j·√3/2, 0))",
    example: "cylinder = 0.22\nheight = 0.4\nhexagonal = 2\npitch = 0.5",
    cells: Some(cells_of),
    bend: Some(|build| {
        let rings = build.arguments().whole("hexagonal").map_or(0, |rings| (*rings).max(0));
        let pitch = build.number("pitch")?;
        let mut places = Vec::new();
        for j in -rings..=rings {
            for i in (-rings).max(-rings - j)..=rings.min(rings - j) {
                let (i, j) = (i as f64, j as f64);
                places.push(CopyPlace::moved(DVec3::new(i + j / 2.0, j * 0.75_f64.sqrt(), 0.0) * pitch));
            }
        }
        copies_of(build, places)
    }),
    ..Spec::PLAIN
};
