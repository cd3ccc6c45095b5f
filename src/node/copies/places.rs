//! Copies in given places.

use crate::node::copied::{cells_of, copies_of};
use crate::node::spec::Spec;
use crate::text::key::Absent::Nothing;
use crate::text::key::{Key, Kind};

/// Copies in given places.
pub const NODE: Spec = Spec {
    key: Key::new(
        "places",
        Kind::Places,
        Nothing,
        "Copies in these places: `[[x, y, z], …]`, or a CSV file. Each may also have a scale, `[x, y, z, scale]`, angles about \
         the axes as `rotate` has them, `[x, y, z, rx, ry, rz]`, or both, `[x, y, z, rx, ry, rz, scale]`.",
    ),
    example: "box = 0.4\nplaces = [[-0.7, 0, 0], [0, 0.5, 0.2, 1.6], [0.8, 0, 0, 0, 30, 45]]",
    cells: Some(cells_of),
    bend: Some(|build| {
        let places = build.arguments().places("places").expect("it must be there").rows.clone();
        copies_of(build, places)
    }),
    ..Spec::PLAIN
};
