//! The colours of a volume.

use crate::node::keys::{FRAME_OFFSET, OUTSIDE_FRAMES};
use crate::node::source::{OUTSIDE, POWER, Source, of_volume, power_is_used};
use crate::text::key::Absent::{Required, Text};
use crate::text::key::{Key, Kind};

/// The colours of a volume.
pub const NODE: Source<3> = Source {
    key: Key::new(
        "vdb",
        Kind::Paths,
        Required,
        "The colours of a volume of voxels in a `.vdb` file, such as one written here: scene-linear, trilinear \
         between voxels. They stand in the shape's own space, before `scale`.",
    ),
    parameters: &[
        Key::new("grid", Kind::Text, Text("Cd"), "The grid: three numbers a voxel, its voxels cubes along the axes."),
        OUTSIDE,
        POWER,
        FRAME_OFFSET,
        OUTSIDE_FRAMES,
    ],
    formula: "Σ cⱼ/dⱼᵖ / Σ 1/dⱼᵖ (STB, eq. 4), to 1/127 of the range of colours",
    check: power_is_used,
    is_volume: true,
    build: of_volume,
    ..Source::PLAIN
};
