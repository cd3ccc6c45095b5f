//! The scenes inside the program, and the files they name.

/// A scene inside the program.
struct BuiltIn {
    name: &'static str,
    text: &'static str,
    line: &'static str,
}

const SCENES: &[BuiltIn] = &[
    BuiltIn {
        name: "sphere",
        text: include_str!("../../scenes/sphere.toml"),
        line: "one coloured ball, the smallest scene",
    },
    BuiltIn { name: "heart", text: include_str!("../../scenes/heart.toml"), line: "the heart surface, one colour" },
    BuiltIn {
        name: "cube-to-heart",
        text: include_str!("../../scenes/cube-to-heart.toml"),
        line: "a cube becomes a heart",
    },
    BuiltIn {
        name: "three-ways",
        text: include_str!("../../scenes/three-ways.toml"),
        line: "a cube, a heart and a ring in a chain, with a scalar that goes with them",
    },
    BuiltIn {
        name: "red-blue",
        text: include_str!("../../scenes/red-blue.toml"),
        line: "how alpha and beta carry colour: --set alpha=3 --set beta=0.25",
    },
    BuiltIn {
        name: "displacement",
        text: include_str!("../../scenes/displacement.toml"),
        line: "bumps become grooves: a scalar moves the surface and goes through the morph",
    },
    BuiltIn {
        name: "microstructure",
        text: include_str!("../../scenes/microstructure.toml"),
        line: "a lattice becomes a gyroid inside a body",
    },
    BuiltIn {
        name: "octopus",
        text: include_str!("../../scenes/octopus.toml"),
        line: "a shape takes on the colours of what it sits on",
    },
    BuiltIn {
        name: "cubism",
        text: include_str!("../../scenes/cubism.toml"),
        line: "two cubes of coloured, faceted cells flow into one another",
    },
    BuiltIn {
        name: "cubism-sliced",
        text: include_str!("../../scenes/cubism-sliced.toml"),
        line: "the same, cut open in every frame: the colours inside",
    },
    BuiltIn {
        name: "partitions",
        text: include_str!("../../scenes/partitions.toml"),
        line: "a figure becomes a lamp, part by part",
    },
    BuiltIn { name: "bat", text: include_str!("../../scenes/bat.toml"), line: "a flat bat of fourteen unions" },
    BuiltIn {
        name: "treble-clef",
        text: include_str!("../../scenes/treble-clef.toml"),
        line: "a flat treble clef of circles",
    },
    BuiltIn {
        name: "star-inside",
        text: include_str!("../../scenes/star-inside.toml"),
        line: "a flat star, coloured by how far heat spreads inside",
    },
    BuiltIn {
        name: "snowflake",
        text: include_str!("../../scenes/snowflake.toml"),
        line: "a flat snowflake, six times the same arm",
    },
    BuiltIn { name: "robot", text: include_str!("../../scenes/robot.toml"), line: "a flat robot of 39 set operations" },
    BuiltIn {
        name: "bat-to-robot",
        text: include_str!("../../scenes/bat-to-robot.toml"),
        line: "the bat becomes the robot, colours by hue",
    },
    BuiltIn {
        name: "heart-slabs",
        text: include_str!("../../scenes/heart-slabs.toml"),
        line: "a heart filled with walls, cut open",
    },
    BuiltIn { name: "marble", text: include_str!("../../scenes/marble.toml"), line: "a heart of marble" },
    BuiltIn {
        name: "wood-morph",
        text: include_str!("../../scenes/wood-morph.toml"),
        line: "a heart of four woods becomes a wooden ring",
    },
    BuiltIn { name: "aitch", text: include_str!("../../scenes/aitch.toml"), line: "a wooden H, rings by distance" },
    BuiltIn {
        name: "covid",
        text: include_str!("../../scenes/covid.toml"),
        line: "a virus cell of hundreds of parts, cut open",
    },
    BuiltIn {
        name: "conformal-ell",
        text: include_str!("../../scenes/conformal-ell.toml"),
        line: "colours that follow the inside of a bent body, and the same through the air",
    },
    BuiltIn {
        name: "in-turn",
        text: include_str!("../../scenes/in-turn.toml"),
        line: "a lamp becomes a mushroom, part by part",
    },
    BuiltIn {
        name: "boot",
        text: include_str!("../../scenes/boot.toml"),
        line: "a boot of foam, cut open, whose colours and cells go over along the inside",
    },
    BuiltIn {
        name: "graded",
        text: include_str!("../../scenes/graded.toml"),
        line: "an arm of gyroid, cut open, from thin to thick sheets along the inside",
    },
    BuiltIn {
        name: "horn",
        text: include_str!("../../scenes/horn.toml"),
        line: "a horn of foam, cut open, whose cells grow along the inside",
    },
    BuiltIn { name: "crawl", text: include_str!("../../scenes/crawl.toml"), line: "a change that crawls along a vine" },
    BuiltIn {
        name: "gears",
        text: include_str!("../../scenes/gears.toml"),
        line: "three gear wheels that turn as their teeth have it",
    },
    BuiltIn {
        name: "logo-text",
        text: include_str!("../../scenes/logo-text.toml"),
        line: "letters with round edges on a plate with a rim",
    },
    BuiltIn { name: "rock", text: include_str!("../../scenes/rock.toml"), line: "a weathered rock with strata" },
    BuiltIn {
        name: "wine-glass",
        text: include_str!("../../scenes/wine-glass.toml"),
        line: "a glass of wine, cut open",
    },
    BuiltIn { name: "chess-king", text: include_str!("../../scenes/chess-king.toml"), line: "a king of a chess set" },
    BuiltIn { name: "bottle", text: include_str!("../../scenes/bottle.toml"), line: "a bottle with a liquid in it" },
    BuiltIn { name: "bone", text: include_str!("../../scenes/bone.toml"), line: "a bone with pores, cut open" },
    BuiltIn { name: "rope", text: include_str!("../../scenes/rope.toml"), line: "a rope of three strands with a knot" },
    BuiltIn { name: "coral", text: include_str!("../../scenes/coral.toml"), line: "a colony of coral" },
    BuiltIn { name: "crowd", text: include_str!("../../scenes/crowd.toml"), line: "five hundred people on a hill" },
];

const FILES: &[(&str, &[u8])] = &[
    ("bat.toml", include_bytes!("../../scenes/bat.toml")),
    ("robot.toml", include_bytes!("../../scenes/robot.toml")),
    ("ball.vdb", include_bytes!("../../scenes/ball.vdb")),
    ("cube.obj", include_bytes!("../../scenes/cube.obj")),
    ("leaf.png", include_bytes!("../../scenes/leaf.png")),
    ("logo.svg", include_bytes!("../../scenes/logo.svg")),
    ("points.csv", include_bytes!("../../scenes/points.csv")),
    ("relief.png", include_bytes!("../../scenes/relief.png")),
];

/// The names of the built-in scenes, simple ones first.
pub fn builtin_names() -> impl Iterator<Item = &'static str> {
    SCENES.iter().map(|scene| scene.name)
}

/// The text of a built-in scene, to be changed and used.
pub fn builtin_text(name: &str) -> Option<&'static str> {
    SCENES.iter().find(|scene| scene.name == name).map(|scene| scene.text)
}

/// What a built-in scene shows, in one line, and what variants it has.
pub fn builtin_line(name: &str) -> Option<String> {
    let BuiltIn { text, line, .. } = SCENES.iter().find(|scene| scene.name == name)?;
    let variant = |line: &'static str| Some(line.strip_prefix("[variant.")?.split_once(']')?.0);
    let variants: Vec<&str> = text.lines().filter_map(variant).filter(|name| !name.contains('.')).collect();
    Some(match variants.as_slice() {
        [] => (*line).to_owned(),
        [one] => format!("{line}; variant {one}"),
        all => format!("{line}; variants {}", all.join(", ")),
    })
}

/// A file that built-in scenes name.
pub(crate) fn file(name: &str) -> Option<(&'static str, &'static [u8])> {
    FILES.iter().find(|file| file.0 == name).copied()
}
