//! Every key of the format, in one place: what is checked, what is proposed when a name is wrong, what a default
//! is, and what `docs/scene.md` says.

mod morph;

pub use morph::{DELAY, FILL, MORPH, ROUND, morph_keys};

use crate::distance::method::{DEPTHS, NAMES, USUAL};
use crate::text::key::{Absent, Key, Kind, Limit};
use crate::vdb::PROGRAM_NAMES;

use Absent::{Nothing, Number, Required, Text, Words};

/// The seed of one choice at random.
pub(crate) const fn seed(text: &'static str) -> Key {
    Key::new("seed", Kind::Seed, Words("from the scene's `seed` and the name"), text).limit(Limit::NotNegative)
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
    Key::new(
        "import",
        Kind::Table,
        Nothing,
        "Other scene files, each with a name that stands before those of its shapes: `import.props = \"props.toml\"`, then \
         `\"props/glass\"`.",
    ),
    Key::new("param", Kind::Table, Nothing, "Numbers with names, for formulas and `--set`."),
    Key::new("palette", Kind::Table, Nothing, "Lists of colours with names."),
    Key::new("color", Kind::Table, Nothing, "Colours with names.").also(&["colour"]),
    Key::new("cells", Kind::Table, Nothing, "Octrees with names: what facets and copies go by."),
    Key::new(
        "operation",
        Kind::Table,
        Nothing,
        "Set operations, blends and other functions of shapes of the scene's own.",
    ),
    Key::new("shape", Kind::Table, Nothing, "The shapes."),
    Key::new("morph", Kind::Table, Nothing, "What becomes what."),
    Key::new("output", Kind::Table, Nothing, "How fine, and which grids."),
    Key::new("variant", Kind::Table, Nothing, "Other values for `--variant NAME`."),
];

/// Lengths that a scene's 1 can stand for.
pub const UNITS: &[&str] = &["m", "cm", "mm", "km", "in", "ft"];

/// A unit of length in metres.
pub fn metres(unit: &str) -> f64 {
    match unit {
        "cm" => 0.01,
        "mm" => 0.001,
        "km" => 1000.0,
        "in" => 0.0254,
        "ft" => 0.3048,
        _ => 1.0,
    }
}

/// Which file of a sequence stands for a frame.
pub(crate) const FRAME_OFFSET: Key = Key::new(
    "frame_offset",
    Kind::Whole,
    Number(0.0),
    "Of files by frame, such as `sim.####.vdb`: what is added to a frame's number for its file's. 10 shows file 11 at frame 1.",
)
.limit(Limit::Within(-1e9, 1e9));

/// What stands for a frame that a sequence has no file of.
pub(crate) const OUTSIDE_FRAMES: Key = Key::new(
    "outside_frames",
    Kind::Choice(&["error", "hold", "loop"]),
    Text("error"),
    "Of files by frame: what frames before the first file and after the last one show. `error`: nothing; such frames are refused. `hold`: the first file, or the last. `loop`: the files again from the first.",
);

/// How large a shape is made.
pub const SCALE: Key = Key::new("scale", Kind::Lengths, Number(1.0), "How many times as large.").limit(Limit::Positive);

/// How a shape is turned.
pub const ROTATE: Key =
    Key::new("rotate", Kind::Vector, Number(0.0), "Turned about the fixed x, then y, then z axis.").unit("degrees");

/// Where a shape is moved.
pub const MOVE: Key = Key::new("move", Kind::Vector, Number(0.0), "Moved along x, y and z.").unit("units");

/// What is done to a shape, in the order of the list.
pub const DO: Key = Key::new(
    "do",
    Kind::Steps,
    Nothing,
    "What is done to it, in the order of this list: `do = [{ twist = 30 }, { move = [1, 0, 0] }]`. Each table has one of \
     the keys above, or `scale`, `rotate` or `move`, with its parameters. A shape with `do` has none of these keys beside it.",
);

/// The smooth step in the place of the sign.
const STEP: Key = Key::new(
    "step",
    Kind::Constant,
    Nothing,
    "s of the smooth step tanh(d/s) in the place of the sign (HFRep, eq. 23), of the distances that are written and drawn: they \
     become abs(d)·tanh(d/s). For comparison only: the result has no slope on the surface, which programs take the normal from.",
)
.limit(Limit::Positive)
.unit("voxels");

/// `distance` written as a table.
pub const ADF: &[Key] = &[
    Key::new(
        "adf",
        Kind::Whole,
        Required,
        "How often the tree is halved at most, from a cube (in the plane a square) of four times the longest side on.",
    )
    .limit(Limit::Within(DEPTHS.0 as f64, DEPTHS.1 as f64)),
    Key::new(
        "restore",
        Kind::Choice(&["spline", "linear"]),
        Text("spline"),
        "What a cell is between its corners: `spline` has one slope everywhere; of `linear` slopes jump from cell to cell, and values where cells of different size meet.",
    ),
];

/// What every shape takes beside what it is and what is done to it: where it stands, and its attributes.
pub const SHAPE: &[Key] = &[
    DO,
    SCALE,
    ROTATE,
    MOVE,
    Key::new("color", Kind::Colour, Words("`#cccccc` where another shape has a colour"), "Its colour.")
        .also(&["colour"]),
    Key::new(
        "attribute",
        Kind::Table,
        Nothing,
        "Numbers of any name that go with the surface, `attribute.roughness = 0.4`; each becomes a grid of its name.",
    ),
    Key::new(
        "distance",
        Kind::Distance(&NAMES),
        Text(USUAL),
        "What measures its distance, wherever that is asked for (`offset`, `displace`, `bands`, a morph, …): see \
         [accuracy.md](accuracy.md). Any but the first is measured even where F is the distance. Shapes of the plane are \
         measured by `closest-point` and `adf`.",
    ),
    STEP,
    Key::new(
        "let",
        Kind::Table,
        Nothing,
        "Names for its formulas: `let.r = \"length(x, y)\"`, a formula, number or keys each, of one another in any order.",
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
    Key::new("min", Kind::Constant, Nothing, "The least that it may be: less is an error, also by `--set`."),
    Key::new("max", Kind::Constant, Nothing, "The greatest that it may be."),
    Key::new("range", Kind::Table, Nothing, "Both at once: `[least, greatest]`."),
    Key::new("text", Kind::Text, Nothing, "What it is."),
];

/// An operation of a scene's own.
pub const OPERATION: &[Key] = &[
    Key::new("fields", Kind::Names, Required, "Names for the shapes' F in the formula; a shape gives as many shapes."),
    Key::new(
        "formula",
        Kind::Formula,
        Required,
        "F of the whole, positive inside, of the fields, `param` names of its own, and all that formulas know.",
    ),
    Key::new(
        "param",
        Kind::Table,
        Nothing,
        "Numbers of its own, each with what holds where a shape leaves it out: `param.k = 0.25`, or a table as in `[param]`.",
    ),
    Key::new(
        "reach",
        Kind::Constant,
        Words("any F will do"),
        "How far from their surfaces the shapes' F must be distances. Where one is not, its distance is measured first.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    Key::new(
        "rises_in",
        Kind::Names,
        Nothing,
        "The fields with which F never falls. If it is all of them, shapes that are distances outside make a box of the whole.",
    ),
    Key::new(
        "lipschitz",
        Kind::Constant,
        Nothing,
        "How much F changes at most where no field changes by more than 1. Frames are found faster.",
    )
    .limit(Limit::Positive),
];

/// Names of colour spaces that colours are mixed in.
pub const COLOUR_SPACES: &[&str] = &["auto", "rgb", "hsv", "lab", "lch", "oklab", "oklch"];

/// Grids whose names no scalar can have.
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
        Words("all there are but `density` and `vel`"),
        "Which grids are written: `surface`, `density`, `Cd`, `vel`, and the names of attributes. `density` is fog: 1 inside, from 0 at the surface up to that as deep as the band; an `attribute.density` stands for the 1, and is written wherever there is one.",
    ),
    Key::new(
        "inside",
        Kind::Flag,
        Text("false"),
        "Colour and attributes through all of the inside, instead of in the band alone: to be cut open, and for fog. `density` implies it.",
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
    Key::new(
        "distance",
        Kind::Distance(&NAMES),
        Words("that of the shape that is baked; of a morph `closest-point`"),
        "What measures the distances of `surface`: see [accuracy.md](accuracy.md). Its sign, which voxels it has and where \
         colours are taken are the same by each.",
    ),
    STEP,
    Key::new(
        "color_name",
        Kind::Text,
        Words("`Cd`, or as `for` has it"),
        "The colour grid's name.",
    )
    .also(&["colour_name"]),
    Key::new(
        "for",
        Kind::Choice(PROGRAM_NAMES),
        Nothing,
        "A program that a `.vdb` is for: its grids have the names and types by which that finds them, see [output.md](output.md#grids-for-programs). Of renderers that show fog alone `density` is among them.",
    ),
    Key::new(
        "color_space",
        Kind::Choice(&["lin_rec709_scene", "lin_ap1_scene", "lin_rec2020_scene"]),
        Words("`lin_rec709_scene`, without a tag"),
        "The scene-linear space of the colour grid in `.vdb` files, which is said in its metadata `colorInteropID`: Rec.709 with sRGB's primaries, ACEScg, or Rec.2020. Renderers do not convert it.",
    )
    .also(&["colour_space"]),
];
