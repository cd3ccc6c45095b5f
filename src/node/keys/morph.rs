//! The keys of `[morph]` but for those of one mode alone, and of the tables in it.

use super::Absent::{Nothing, Number, Required, Text, Words};
use super::{COLOUR_SPACES, Key, Kind, Limit};
use crate::node::list::MODES;

/// What all modes share.
pub const MORPH: &[Key] = &[
    Key::new("from", Kind::Shape, Words("must be there, or `through`"), "What it is at the first frame."),
    Key::new("to", Kind::Shape, Words("must be there, or `through`"), "What it is at the last frame."),
    Key::new(
        "through",
        Kind::Shapes(1),
        Nothing,
        "In place of `from` and `to`: the shapes that it becomes one after the other, each by a morph of its own with all other keys alike. At its frame each is shown as it is, so `volume` is 1 there.",
    ),
    Key::new(
        "at",
        Kind::KeyFrames,
        Words("evenly over `over`"),
        "The frame of each shape of `through`; before the first and after the last it stands.",
    ),
    Key::new(
        "mode",
        Kind::Choice(&MODE_NAMES),
        Text("volume"),
        "How the shape changes: one of the [modes](nodes.md#modes-of-a-morph), each with keys of its own beside these.",
    ),
    Key::new(
        "pace",
        Kind::Choice(&["even", "t"]),
        Text("even"),
        "`even`: every frame changes the shape as much as the others; what carries both objects along is no change. `t`: the papers' way.",
    ),
    Key::new(
        "carry",
        Kind::Choice(&["none", "centroid", "inertia", "anchors"]),
        Words("`mode = \"volume\"`: `none` where the boxes of the two meet at any time of `over`, else `centroid`; other modes: `none`"),
        "The way from where the first shape is to where the last one is. Both go along it, the one out of which the other comes, straight and as fast as `ease` says; the whole blend is made in the frame that goes with them, and each is where it is at its own frame. `none`: both stay, and what lies apart flows over by a bridge or melts away here and grows there. `centroid`: from centre of volume to centre of volume. `inertia`: the same, and turns the longest axis of the one to that of the other, the least turn there is; axes that are as long as one another decide no turn. `anchors`: from the places of `anchors`. What stands in the world, `cut`, `fill` and `delay`, is not carried.",
    ),
    Key::new(
        "anchors",
        Kind::PlacePairs,
        Nothing,
        "For `carry = \"anchors\"`, which may be left out then (`\"none\"` leaves them aside): places of the first shape and what they become on the last, `[[[0, 0, 1], [3, 0, 2]], …]`, in the world, each as its shape stands at the first and at the last frame of `over`, and in or on it; with `through` lists with a place of each of its shapes. One moves; two turn besides, the least turn there is; three or more that are not on one line turn and move as fits them best. Sizes do not change.",
    )
    .unit("units"),
    Key::new("scale", Kind::Number, Number(1.0), "How many times as large the whole morph is made, about the origin; it stands still. What grows over time changes its shape: by a `scale` of both shapes.")
        .limit(Limit::Positive),
    Key::new(
        "rotate",
        Kind::Vector,
        Number(0.0),
        "The whole morph turned about the fixed x, then y, then z axis, as both of its shapes would be by a `rotate` of their own after all else.",
    )
    .unit("degrees"),
    Key::new(
        "move",
        Kind::Vector,
        Number(0.0),
        "The whole morph moved along x, y and z, after `scale` and `rotate`. What stands in the world, `cut`, `fill` and `delay`, stays; `anchors` are places after it.",
    )
    .unit("units"),
    Key::new(
        "arc",
        Kind::Vector,
        Words("straight"),
        "How far the middle of that way lies off the straight one, in the world: `[0, 0, 1]` goes over the top by a unit. Three \
         numbers without time. Carries by itself, as by `carry = \"centroid\"`.",
    )
    .unit("units"),
    Key::new(
        "carry_ease",
        Kind::Progress,
        Words("`ease`"),
        "How fast the objects go along that way, as `ease` says how fast the shape changes. Carries by itself, too.",
    )
    .limit(Limit::Within(0.0, 1.0)),
    Key::new("color_space", Kind::Choice(COLOUR_SPACES), Text("auto"), "How colours mix. `auto` runs between Oklab's straight line and Oklch's arc: opposite hues meet neither in grey-brown nor in a rainbow; the side on which nearly opposite hues pass is that of both objects' mean colours, so it is one for all of a morph. The others are the space to mix in.")
        .also(&["colour_space"]),
    Key::new("alpha", Kind::Number, Number(0.3), "How colours come: 0.1 sweep over the shape, 3 everywhere at once. [Nine pictures](cases.md#what-α-and-β-do-stti-fig-3-to-5) of it and of `beta`.")
        .limit(Limit::NotNegative),
    Key::new(
        "beta",
        Kind::Number,
        Number(0.5),
        "Which object's distance counts more for colours; 0.5 is both alike.",
    )
    .limit(Limit::Within(0.0, 1.0)),
    Key::new(
        "pairs",
        Kind::ShapePairs,
        Nothing,
        "Which part becomes which: `[[\"head\", \"lid\"], [\"body\", \"bowl\"]]`, operands of the unions `from` and `to`, each in one pair; with `through` lists with a part of each of its shapes. Each pair is morphed by itself, and the whole has the colours and attributes of a pair where that pair is (STTI, section 4.2.2). `\"auto\"`: those that lie nearest to one another in their wholes and are most alike in size, the nearest first; where one object has more parts, the rest go with the nearest. `hfvdb check` says which.",
    ),
    Key::new(
        "overlap",
        Kind::Choice(&["priority", "mix"]),
        Text("priority"),
        "Where several of `pairs` are: the last of them as they are listed, or the mean of all.",
    ),
    Key::new(
        "master",
        Kind::Shape,
        Nothing,
        "A part whose pair gives its colours where none of `pairs` is. Left out: the nearest pair, which suits surfaces; the whole's lies beside those of the pairs, so a master shows there, often over a whole part.",
    ),
    Key::new(
        "master_color",
        Kind::Colour,
        Nothing,
        "In place of `master`: a colour of its own where none of `pairs` is, for insides: on surfaces it shows as a master does. Numbers are those of the nearest pair there.",
    )
    .also(&["master_colour"]),
    Key::new(
        "over",
        Kind::Frames,
        Words("`frames`"),
        "The frames in which the shape changes; before and after it stands.",
    ),
    Key::new("color_over", Kind::Frames, Words("`over`"), "The frames in which the colours change.")
        .also(&["colour_over"]),
    Key::new(
        "ease",
        Kind::Progress,
        Text("linear"),
        "How fast the shape changes: `smooth` starts and ends at rest; keys or a formula are the progress itself, 0 at the first frame of `over`, 1 at its last, and may rest or go back on the way. Equal steps of it change equal volumes (with `pace = \"t\"`, t).",
    )
    .limit(Limit::Within(0.0, 1.0)),
    Key::new(
        "octopus",
        Kind::Flag,
        Text("false"),
        "Colours run on past their end: the last one's creeps outward (STTI).",
    ),
    Key::new(
        "displace",
        Kind::Scalar,
        Nothing,
        "Moves the surface of every frame along its normal by an attribute that goes through the morph, in units, outward where that is positive (STTI). The shapes' own `displace` comes before the morph, this one after it.",
    ),
    Key::new(
        "fill",
        Kind::Fill,
        Nothing,
        "Leaves an inner structure of every frame: where (1 − ω)·a + ω·b ≥ 0, a and b the F of two shapes and ω an attribute that goes through the morph (STTI, section 6.5). The structures stand in the world and may be endless.",
    ),
    Key::new("cut", Kind::Shape, Nothing, "Taken away from every frame, to look inside. Stands in the world."),
    Key::new(
        "keep",
        Kind::Choice(&["all", "largest"]),
        Text("all"),
        "Which pieces of a frame stay, of the first and the last one too. `largest`: none but the one of most volume, so no crumbs, and of letters one; `min_piece` leaves out crumbs alone.",
    ),
    Key::new(
        "height",
        Kind::Constant,
        Words("an eighth of the longest side"),
        "How high a morph of shapes of the plane is extruded, from its bottom to its top; of shapes of the plane alone.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    Key::new("min_piece", Kind::Constant, Number(0.0), "Pieces of less volume, in cubic units, are left out; the largest always stays.")
        .limit(Limit::NotNegative),
];

/// The table of `fill`.
pub const FILL: &[Key] = &[
    Key::new(
        "mix",
        Kind::Shapes(1),
        Required,
        "The two structures: what is where the attribute is 0, and where it is 1.",
    ),
    Key::new("by", Kind::Scalar, Required, "The attribute that mixes them."),
];

/// The table of `round`, in the units of a0 … a3.
pub const ROUND: &[Key] = &[
    Key::new("a0", Kind::Number, Required, "How much is added at the cut; a negative number takes away."),
    Key::new("reach", Kind::Number, Number(1.0), "How far it reaches, in distance and in time (a1 and a2).")
        .limit(Limit::Positive),
    Key::new("a3", Kind::Number, Number(1.0), "How far the bound reaches.").limit(Limit::Positive),
    Key::new("depth", Kind::Number, Number(1.0), "How far behind the cut, in t, the bound stands.")
        .limit(Limit::NotNegative)
        .also(&["P_c"]),
];

/// The table of `delay`.
pub const DELAY: &[Key] = &[
    Key::new(
        "shape",
        Kind::Shape,
        Required,
        "The shape whose colour or attribute it is, as it stands at the first frame.",
    ),
    Key::new(
        "attribute",
        Kind::Text,
        Words("the luminance of its colour"),
        "The name of the shape's `attribute` that says how long to wait.",
    ),
    Key::new("most", Kind::Constant, Number(0.5), "The delay where that is 1.").limit(Limit::Within(0.0, 0.95)),
];

/// The names of the modes.
const MODE_NAMES: [&str; MODES.len()] = {
    let mut names = [""; MODES.len()];
    let mut row = 0;
    while row < names.len() {
        names[row] = MODES[row].key.name;
        row += 1;
    }
    names
};

/// All keys of `[morph]`: those of each mode come last.
pub fn morph_keys() -> impl Iterator<Item = &'static Key> {
    MORPH.iter().chain(MODES.iter().flat_map(|mode| mode.parameters))
}
