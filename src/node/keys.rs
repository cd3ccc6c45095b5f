//! Every key of the format, in one place: what is checked, what is proposed when a name is wrong, what a default
//! is, and what `docs/scene.md` says.

mod colours;
mod morph;
mod scalars;

pub use colours::COLOURS;
pub use morph::{BY_MODE, DELAY, FILL, MORPH, ROUND};
pub use scalars::SCALARS;

use crate::text::key::{Absent, Key, Kind, Limit};

/// A maker: the one key that says what a shape is, and the parameters beside it.
#[derive(Clone, Copy, Debug)]
pub struct Maker {
    /// The key itself; its value is the main parameter, or the operands.
    pub key: Key,
    /// What else it takes.
    pub parameters: &'static [Key],
    /// Its function, positive inside, where one line says it.
    pub formula: &'static str,
}

use Absent::{Nothing, Number, Required, Text, Vector, Words};

/// The seed of one choice at random.
const fn seed(text: &'static str) -> Key {
    Key::new("seed", Kind::Whole, Words("from the scene's `seed` and the name"), text).limit(Limit::NotNegative)
}

/// The top of a scene.
pub const SCENE: &[Key] = &[
    Key::new("hfvdb", Kind::Whole, Number(1.0), "The format's version; 1 is the only one.")
        .limit(Limit::Within(1.0, 1.0)),
    Key::new(
        "frames",
        Kind::Frames,
        Words("a still: t = 0 in every frame"),
        "The shot. t runs from 0 at its first frame to 1 at its last.",
    ),
    Key::new("fps", Kind::Constant, Number(24.0), "Frames a second: what makes `time` seconds.")
        .limit(Limit::Positive)
        .unit("1/s"),
    Key::new("seed", Kind::Whole, Number(0.0), "The number that everything at random starts from.")
        .limit(Limit::NotNegative),
    Key::new("unit", Kind::Choice(UNITS), Text("m"), "The length that 1 stands for. Goes into the files' metadata."),
    Key::new("up", Kind::Choice(&["y", "z"]), Text("z"), "The axis that points up. Goes into the files' metadata."),
    Key::new("param", Kind::Table, Nothing, "Numbers with names, for formulas and `--set`."),
    Key::new("palette", Kind::Table, Nothing, "Lists of colours with names."),
    Key::new("color", Kind::Table, Nothing, "Colours with names.").also(&["colour"]),
    Key::new("cells", Kind::Table, Nothing, "Octrees with names: what facets and copies go by."),
    Key::new("shape", Kind::Table, Nothing, "The shapes."),
    Key::new("morph", Kind::Table, Nothing, "What becomes what."),
    Key::new("output", Kind::Table, Nothing, "How fine, and which grids."),
    Key::new("variant", Kind::Table, Nothing, "Other values for `--variant NAME`."),
];

/// Lengths that a scene's 1 can stand for.
pub const UNITS: &[&str] = &["m", "cm", "mm", "km", "in", "ft"];

/// The makers of shapes.
pub const MAKERS: &[Maker] = &[
    Maker {
        key: Key::length("sphere", Required, "A ball around the origin: its radius."),
        parameters: &[],
        formula: "r − |p|",
    },
    Maker {
        key: Key::new(
            "box",
            Kind::Lengths,
            Required,
            "A box around the origin: its edge lengths; one number is a cube.",
        )
        .limit(Limit::Positive)
        .unit("units"),
        parameters: &[],
        formula: "the signed distance to it",
    },
    Maker {
        key: Key::new("ellipsoid", Kind::Vector, Required, "An ellipsoid around the origin: its half axes.")
            .limit(Limit::Positive)
            .unit("units"),
        parameters: &[],
        formula: "(1 − |(x/a, y/b, z/c)|)·min(a, b, c)",
    },
    Maker {
        key: Key::length("cylinder", Required, "A cylinder along z around the origin: its radius."),
        parameters: &[Key::length("height", Words("twice the radius"), "From its bottom to its top.")],
        formula: "the signed distance to it",
    },
    Maker {
        key: Key::length("torus", Required, "A ring around the z axis: the radius of its middle line."),
        parameters: &[Key::length("tube", Words("a quarter of the radius"), "The radius of its tube.")],
        formula: "s − |(|(x, y)| − r, z)|",
    },
    Maker {
        key: Key::length("capsule", Required, "All that is near a straight line: the radius."),
        parameters: &[Key::length(
            "length",
            Words("twice the radius"),
            "The length of the line, along z around the origin.",
        )],
        formula: "r − |p − q|, q the nearest of the line",
    },
    Maker {
        key: Key::new(
            "half_space",
            Kind::Vector,
            Required,
            "All that lies behind a plane: the direction that points out of it, of any length but 0. Without end: for cutting.",
        ),
        parameters: &[Key::new(
            "offset_along",
            Kind::Number,
            Number(0.0),
            "How far the plane lies from the origin, along that direction.",
        )
        .unit("units")],
        formula: "d − n·p",
    },
    Maker {
        key: Key::length(
            "slab",
            Required,
            "All between two planes around the origin: the thickness. Without end: for cutting.",
        ),
        parameters: &[Key::new("normal", Kind::Vector, Vector([0.0, 0.0, 1.0]), "The direction across it.")],
        formula: "w/2 − |n·p|",
    },
    Maker {
        key: Key::length(
            "heart",
            Required,
            "A heart around the origin, upright along z, front towards −y: its width along x.",
        ),
        parameters: &[],
        formula: "z·∛(x² + 9/80·y²) − (x² + 9/4·y² + z² − 1), scaled: the cube roots of the well-known sextic",
    },
    Maker {
        key: Key::new(
            "formula",
            Kind::Formula,
            Required,
            "F itself, positive inside, of x, y, z, t, frame, time, pi and `[param]` names.",
        ),
        parameters: &[],
        formula: "",
    },
    Maker {
        key: Key::new(
            "mesh",
            Kind::Path,
            Required,
            "A closed mesh: OBJ, PLY. Inside is where its winding number is not 0: pieces that overlap or cross \
             themselves are one solid, a piece wound inward is a hollow in the one around it, and apart from others it is \
             turned over. The colours of its vertices, or of its faces (PLY), are its colour where `color` is left out; materials are not read.",
        ),
        parameters: &[
            Key::new(
                "up",
                Kind::Choice(&["y", "z"]),
                Words("the scene's `up`"),
                "The axis that points up in the file: `\"y\"` for OBJ by Blender's default export. Where the scene's is another, the mesh is turned: (x, y, z) becomes (x, −z, y), or back.",
            ),
            Key::new(
                "vertex_colors",
                Kind::Choice(&["srgb", "linear"]),
                Text("srgb"),
                "How the file's colours are encoded. `linear`: scene-linear Rec.709, which may be above 1.",
            )
            .also(&["vertex_colours"]),
        ],
        formula: "the signed distance to the boundary of that solid",
    },
    Maker {
        key: Key::new(
            "union",
            Kind::Shapes,
            Required,
            "All that lies in any of them. Where they overlap, the later one's colour.",
        ),
        parameters: &[colours::SEAM],
        formula: "a + b + √(a² + b²)",
    },
    Maker {
        key: Key::new("intersection", Kind::Shapes, Required, "What lies in all of them."),
        parameters: &[],
        formula: "a + b − √(a² + b²)",
    },
    Maker {
        key: Key::new("difference", Kind::Shapes, Required, "The first without all others."),
        parameters: &[],
        formula: "a − b − √(a² + b²)",
    },
    Maker {
        key: Key::new("blend", Kind::Shapes, Required, "Two shapes that flow into one another."),
        parameters: &[
            Key::length("blend_radius", Number(0.25), "How near they must be to one another to flow together."),
            Key::new("within", Kind::Shape, Nothing, "The blend stays within this shape (bounded blending)."),
        ],
        formula: "a + b + √(a² + b²) + a₀·disp",
    },
    Maker {
        key: Key::new(
            "facet",
            Kind::Shape,
            Required,
            "A shape whose surface, cell by cell, is cut by a plane at random.",
        ),
        parameters: FACET_PARAMETERS,
        formula: "",
    },
];

const FACET_PARAMETERS: &[Key] = &[
    Key::new("cells", Kind::Cells, Required, "The cells that the surface is cut by."),
    Key::new("tilt", Kind::Constant, Number(20.0), "The most that a plane is tilted.")
        .limit(Limit::Within(0.0, 60.0))
        .unit("degrees"),
    Key::new("cut", Kind::Constant, Number(0.1), "The deepest that a plane cuts.")
        .limit(Limit::NotNegative)
        .unit("units"),
    seed("The number that its chances start from."),
];

/// A key of a number by keys, where it is a table.
pub const KEY: &[Key] = &[
    Key::new("value", Kind::Constant, Required, "The value at the frame."),
    Key::new(
        "in",
        Kind::Table,
        Words("level at a turn, else without overshoot"),
        "The handle towards the key before: `[frames, value]` from the key, frames 0 or less.",
    ),
    Key::new(
        "out",
        Kind::Table,
        Words("level at a turn, else without overshoot"),
        "The handle towards the next key: `[frames, value]` from the key, frames 0 or more.",
    ),
];

/// What every shape takes beside its maker. The order of the text does not matter: this is the order of work.
pub const SHAPE: &[Key] = &[
    Key::new("at", Kind::Copies, Nothing, "Copies in cells, in place of the one at the origin."),
    Key::new(
        "mirror",
        Kind::Choice(&["x", "y", "z"]),
        Nothing,
        "The half on the positive side of the plane through the origin, and its mirror image.",
    ),
    Key::new(
        "offset",
        Kind::Number,
        Number(0.0),
        "Grows the shape by this distance on all sides: its edges become round. A negative number shrinks it: its hollows do.",
    )
    .unit("units"),
    Key::new("shell", Kind::Number, Nothing, "Only a wall of this thickness stays, its middle on the surface.")
        .limit(Limit::Positive)
        .unit("units"),
    Key::new(
        "displace",
        Kind::Scalar,
        Nothing,
        "Moves the surface along its normal by an attribute of the shape, outward where that is positive: F = f + d, f the signed distance and d the attribute at the same point, in units.",
    ),
    Key::new("scale", Kind::Lengths, Number(1.0), "How many times as large.").limit(Limit::Positive),
    Key::new("rotate", Kind::Vector, Number(0.0), "Turned about the fixed x, then y, then z axis.").unit("degrees"),
    Key::new("move", Kind::Vector, Number(0.0), "Moved along x, y and z.").unit("units"),
    Key::new(
        "bounds",
        Kind::Box,
        Nothing,
        "Cut off outside of this box, in the shape's own space. A shape without end needs it. Where it cuts a warning says so; `{ box = …, cut = true }` says that it is meant.",
    ),
    Key::new("color", Kind::Colour, Words("`#cccccc` where another shape has a colour"), "Its colour.")
        .also(&["colour"]),
    Key::new(
        "attribute",
        Kind::Table,
        Nothing,
        "Numbers of any name that go with the surface, `attribute.roughness = 0.4`; each becomes a grid of its name.",
    ),
];

/// Octree cells.
pub const CELLS: &[Key] = &[
    Key::new(
        "octree",
        Kind::Shape,
        Required,
        "The shape around which the octree stands; its leaves are where its surface is.",
    ),
    Key::new("depth", Kind::Depth, Words("`[1, 3]`"), "How often a cell is halved: at least, at most."),
    Key::new("chance", Kind::Constant, Number(0.5), "That a cell between the two is halved once more.")
        .limit(Limit::Within(0.0, 1.0)),
    seed("The number that its chances start from."),
];

/// Copies in cells: the table of `at`.
pub const COPIES: &[Key] = &[
    Key::new(
        "cells",
        Kind::Cells,
        Required,
        "The cells that copies stand in, each on the surface near its cell's middle.",
    ),
    Key::new("pick", Kind::Constant, Number(1.0), "The share of cells that get one.").limit(Limit::Within(0.0, 1.0)),
    seed("The number that the choice starts from."),
];

/// `bounds` written as a table.
pub const BOUNDS: &[Key] = &[
    Key::new("box", Kind::Box, Required, "The box."),
    Key::new("cut", Kind::Flag, Text("false"), "Whether the box is meant to cut the shape; then no warning says so."),
];

/// A parameter written as a table.
pub const PARAMETER: &[Key] = &[
    Key::new("value", Kind::Number, Required, "Its value."),
    Key::new("range", Kind::Table, Nothing, "`[least, greatest]`: another value is an error."),
    Key::new("text", Kind::Text, Nothing, "What it is."),
];

/// Names of colour spaces that colours are mixed in.
pub const COLOUR_SPACES: &[&str] = &["rgb", "hsv", "lab", "lch", "oklab"];

/// Grids that a file can hold, scalars aside.
pub const GRIDS: &[&str] = &["surface", "Cd", "vel"];

/// The output.
pub const OUTPUT: &[Key] = &[
    Key::new("shape", Kind::Shape, Words("the morph, else the one shape that no other uses"), "What is baked."),
    Key::new("voxel_size", Kind::Constant, Words("from `resolution`"), "A voxel's edge.")
        .limit(Limit::Positive)
        .unit("units"),
    Key::new(
        "resolution",
        Kind::Whole,
        Number(256.0),
        "Voxels along the longest side of the box of all that is solid in the whole shot.",
    )
    .limit(Limit::Within(4.0, 65536.0)),
    Key::new("half_width", Kind::Constant, Number(3.0), "Half the band's width.")
        .limit(Limit::Within(1.5, 100.0))
        .unit("voxels")
        .also(&["half_width_voxels"]),
    Key::new(
        "grids",
        Kind::Grids,
        Words("all there are but `vel`"),
        "Which grids are written: `surface`, `Cd`, `vel`, and the names of attributes.",
    ),
    Key::new("half", Kind::Grids, Words("none"), "Which grids keep their numbers in 16 bits."),
    Key::new("compression", Kind::Choice(&["blosc", "zip", "none"]), Text("blosc"), "How files are packed."),
    Key::new(
        "max_speed",
        Kind::Constant,
        Words("the longest side of the shot's box in one frame, for changes of shape an eighth of that"),
        "The greatest speed in `vel`: where surfaces meet, part or vanish they move without limit.",
    )
    .limit(Limit::Positive)
    .unit("units/s"),
    Key::new("color_name", Kind::Text, Text("Cd"), "The colour grid's name.").also(&["colour_name"]),
];

/// The maker that a parameter goes with.
fn owner(makers: &'static [Maker], name: &str) -> Option<&'static str> {
    makers.iter().find(|maker| maker.parameters.iter().any(|key| key.is_called(name))).map(|maker| maker.key.name)
}

/// The maker of shapes that a key goes with.
pub fn shape_owner(name: &str) -> Option<&'static str> {
    owner(MAKERS, name)
}

/// The maker of colours that a key goes with.
pub fn colour_owner(name: &str) -> Option<&'static str> {
    owner(COLOURS, name)
}

/// The maker of scalars that a key goes with.
pub fn scalar_owner(name: &str) -> Option<&'static str> {
    owner(SCALARS, name)
}
