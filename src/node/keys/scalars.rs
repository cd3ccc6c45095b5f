//! Scalars written as tables.

use super::Absent::{Required, Words};
use super::colours::{BY, EDGE, OUTSIDE, POWER, SEAM, SEED};
use super::{Key, Kind, Maker};

/// The makers of scalars: the one key that says what a scalar written as a table is.
pub const SCALARS: &[Maker] = &[
    Maker {
        key: Key::new("values", Kind::Numbers, Required, "One of these numbers at random."),
        parameters: &[BY, EDGE, SEED],
        formula: "",
    },
    Maker {
        key: Key::new("range", Kind::Numbers, Required, "Any number between two at random: the two."),
        parameters: &[BY, EDGE, SEED],
        formula: "",
    },
    Maker {
        key: Key::new(
            "bands",
            Kind::NumberBands,
            Required,
            "Numbers by depth below the shape's surface, as colours have them.",
        )
        .unit("units"),
        parameters: &[],
        formula: "",
    },
    Maker {
        key: Key::new(
            "parts",
            Kind::Shapes(1),
            Required,
            "What the attribute of the same name is on each of these shapes, as colours have them; 0 on those without it.",
        ),
        parameters: &[SEAM],
        formula: "Σ aⱼ/|fⱼ| / Σ 1/|fⱼ| outside (STTI, eq. 6)",
    },
    Maker {
        key: Key::new(
            "vdb",
            Kind::Path,
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
        ],
        formula: "Σ aⱼ/dⱼᵖ / Σ 1/dⱼᵖ (STB, eq. 4), to 1/255 of the range of numbers",
    },
];
