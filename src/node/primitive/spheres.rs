//! Many balls.

use glam::DVec3;

use crate::field::{Balls, Joined};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind};

/// Many balls.
pub const NODE: Spec = Spec {
    key: Key::new(
        "spheres",
        Kind::Rows(1, &[3, 4]),
        Required,
        "Balls: the centre of each, and its radius where it has one of its own. `points` reads them from a file.",
    )
    .unit("units"),
    parameters: &[Key::length("radius", Number(0.1), "The radius of balls that have none of their own.")],
    formula: "max(rᵢ − |p − cᵢ|): the signed distance outside",
    example: "spheres = [[-0.5, 0, 0], [0, 0.3, 0, 0.5], [0.6, 0, 0.2], [0.5, -0.5, -0.3, 0.3]]\nradius = 0.4",
    build: |build| {
        let radius = build.number("radius")?;
        let rows = build.arguments().rows("spheres").expect("it must be there").all.clone();
        let mut all = Vec::with_capacity(rows.len());
        for row in &rows {
            let own = row.get(3).copied().unwrap_or(radius);
            if own <= 0.0 {
                let problem = format!("a radius must be greater than 0, and is {own}");
                return Err(build.wrong("spheres", problem).help("leave it out where `radius` is meant"));
            }
            all.push((DVec3::new(row[0], row[1], row[2]), own));
        }
        Ok(build.graph().field(Joined::shared(Balls::new(all))))
    },
    ..Spec::PLAIN
};
