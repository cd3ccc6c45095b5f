//! Copies in a grid.

use glam::DVec3;

use crate::field::CopyPlace;
use crate::node::copied::{cells_of, copies_of};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Nothing, Number, Text};
use crate::text::key::{Key, Kind};

/// Copies in a grid.
pub const NODE: Spec = Spec {
    key: Key::new(
        "array",
        Kind::Counts,
        Nothing,
        "Copies in a grid: how many along x, y and z. Copies may overlap; each has the shape's colours and scalars, or with \
         `by = \"cell\"` its own.",
    ),
    parameters: &[
        Key::new("spacing", Kind::Lengths, Number(1.0), "How far each is from the next.").unit("units"),
        Key::new(
            "from",
            Kind::Choice(&["middle", "first"]),
            Text("middle"),
            "What of the grid is at the origin: its middle, or its first copy.",
        ),
    ],
    formula: "max over i of f(p − i·s)",
    example: "box = [0.4, 0.3, 0.6]\narray = [3, 4, 1]\nspacing = [0.7, 0.45, 1]",
    cells: Some(cells_of),
    bend: Some(|build| {
        let counts = build.arguments().counts("array").copied().unwrap_or([1; 3]);
        let spacing = build.vector("spacing")?;
        let last = DVec3::from_array(counts.map(|count| f64::from(count) - 1.0)) * spacing;
        let first = if build.arguments().choice("from") == Some(&"first") { DVec3::ZERO } else { -last / 2.0 };
        let [nx, ny, nz] = counts;
        let cells = (0..nx).flat_map(|x| (0..ny).flat_map(move |y| (0..nz).map(move |z| [x, y, z])));
        let at = |cell: [u32; 3]| first + DVec3::from_array(cell.map(f64::from)) * spacing;
        copies_of(build, cells.map(|cell| CopyPlace::moved(at(cell))).collect())
    }),
    ..Spec::PLAIN
};
