//! Colours written as tables.

use crate::attribute::POWERS;

use super::Absent::{Nothing, Number, Required, Text};
use super::{COLOUR_SPACES, Key, Kind, Limit, Maker, seed};

/// The makers of colours: the one key that says what a colour written as a table is.
pub const COLOURS: &[Maker] = &[
    Maker {
        key: Key::new(
            "linear",
            Kind::Components,
            Required,
            "Scene-linear red, green, blue, each 0 or greater. Formulas are held to that.",
        ),
        parameters: &[],
        formula: "",
    },
    Maker {
        key: Key::new(
            "hsv",
            Kind::Components,
            Required,
            "Hue in degrees, saturation and value from 0 to 1, of the sRGB-encoded colour. Formulas are held to that.",
        ),
        parameters: &[],
        formula: "",
    },
    Maker {
        key: Key::new(
            "palette",
            Kind::Palette,
            Required,
            "One of a palette's colours at random: its name, or colours.",
        ),
        parameters: &[BY, EDGE, SEED],
        formula: "",
    },
    Maker {
        key: Key::new("range", Kind::Palette, Required, "Any colour between two at random: the two."),
        parameters: &[
            BY,
            EDGE,
            SEED,
            Key::new("color_space", Kind::Choice(COLOUR_SPACES), Text("oklab"), "The space that they are mixed in.")
                .also(&["colour_space"]),
        ],
        formula: "",
    },
    Maker {
        key: Key::new(
            "bands",
            Kind::Bands,
            Required,
            "Colours by depth below the shape's surface (outside: negative), in its own space before `scale`. Each \
             begins at its depth; what lies before the first has the first's. They show where something cuts into \
             the shape.",
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
            "Each part's colour inside of it, the later one's where parts overlap, and outside of all parts the mean \
             by the inverse of the distances to them. Parts stand in the shape's own space and do not change its form.",
        ),
        parameters: &[SEAM],
        formula: "Σ cⱼ/|fⱼ| / Σ 1/|fⱼ| outside (STTI, eq. 6)",
    },
    Maker {
        key: Key::new(
            "vdb",
            Kind::Path,
            Required,
            "The colours of a volume of voxels in a `.vdb` file, such as one written here: scene-linear, trilinear \
             between voxels. They stand in the shape's own space, before `scale`.",
        ),
        parameters: &[
            Key::new(
                "grid",
                Kind::Text,
                Text("Cd"),
                "The grid: three numbers a voxel, its voxels cubes along the axes.",
            ),
            OUTSIDE,
            POWER,
        ],
        formula: "Σ cⱼ/dⱼᵖ / Σ 1/dⱼᵖ (STB, eq. 4), to 1/127 of the range of colours",
    },
];

pub(super) const OUTSIDE: Key = Key::new(
    "outside",
    Kind::Choice(&["nearest", "potential"]),
    Text("nearest"),
    "How values go on outside of the active voxels: that of their nearest point, or the mean of all voxels weighted by a \
     power of the distance, which takes some seconds more at high resolutions.",
);

pub(super) const POWER: Key = Key::new(
    "power",
    Kind::Whole,
    Number(4.0),
    "`outside = \"potential\"`: the power p. 2 is the paper's, and lets far voxels rule over near ones.",
)
.limit(Limit::Within(*POWERS.start() as f64, *POWERS.end() as f64));

pub(super) const BY: Key = Key::new(
    "by",
    Kind::Choice(&["cell", "voxel"]),
    Text("cell"),
    "What takes one: each cell of `facet` or `at`, or each cube of a lattice.",
);

pub(super) const EDGE: Key = Key::new(
    "voxel_size",
    Kind::Constant,
    Nothing,
    "`by = \"voxel\"`: the cubes' edge, in the shape's own space. The origin is the middle of one.",
)
.limit(Limit::Positive)
.unit("units");

pub(super) const SEED: Key = seed("The number that the choice starts from.");

/// How parts of several colours meet.
pub(crate) const SEAM: Key = Key::new(
    "seam",
    Kind::Constant,
    Number(0.0),
    "Over which width the colours of parts that meet go over into one another; 0 is a sharp edge.",
)
.limit(Limit::NotNegative)
.unit("units");
