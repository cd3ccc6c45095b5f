//! The scalars of a volume.

use crate::node::keys::{FRAME_OFFSET, OUTSIDE_FRAMES};
use crate::node::source::{OUTSIDE, POWER, Source, of_volume, power_is_used};
use crate::text::key::Absent::{Required, Words};
use crate::text::key::{Key, Kind};

/// The scalars of a volume.
pub const NODE: Source<1> = Source {
    key: Key::new(
        "vdb",
        Kind::Paths,
        Required,
        "The numbers of a volume of voxels in a `.vdb` file, as colours have them: trilinear between voxels, in the \
         shape's own space, before `scale`. Of a level set they are distances, positive inside.",
    ),
    parameters: &[
        Key::new(
            "grid",
            Kind::Text,
            Words("the attribute's name"),
            "The grid: one number a voxel, its voxels cubes along the axes.",
        ),
        OUTSIDE,
        POWER,
        FRAME_OFFSET,
        OUTSIDE_FRAMES,
    ],
    formula: "Σ aⱼ/dⱼᵖ / Σ 1/dⱼᵖ (STB, eq. 4), to 1/255 of the range of numbers",
    check: power_is_used,
    is_volume: true,
    build: of_volume,
    ..Source::PLAIN
};
