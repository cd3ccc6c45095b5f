//! `docs/scene.md`, made from the tables that scenes are checked by.

use std::fmt::Write;

use crate::field::functions;
use crate::node::catalogue::table_of;
use crate::node::keys;
use crate::node::list;
use crate::text::builtin::{builtin_line, builtin_names};
use crate::text::key::Key;
use crate::text::keyframes;

const BEGINNING: &str = "\
# The scene format

A scene is one TOML 1.0 file (or the same as JSON, for machines). This page is made from the tables that scenes are
checked by; `hfvdb schema` prints them as a JSON Schema, from which editors complete. `hfvdb scenes` lists the built-in scenes, `hfvdb scenes NAME` prints one to start from, and
`hfvdb check -v SCENE` prints every value and where it comes from.

```toml
hfvdb = 1
frames = \"1-24\"

[shape.cube]
box = 1.6
color = \"#d7263d\"

[shape.heart]
heart = 2.0
color = \"#1b998b\"

[morph]
from = \"cube\"
to = \"heart\"
```

## Values

| what | how it is written |
|---|---|
| number | `2`, `0.5`; a formula of time, `\"0.2*sin(2*pi*t)\"`; keys, `{ 1 = 0, 48 = 90, ease = \"smooth\" }`. frames rise; `ease` is `linear` (when left out), `smooth`, `in`, `out`, `hold` or `bezier`; before the first key and after the last one theirs holds |
| three numbers | `[x, y, z]`, each a number as above |
| formula | text with `x y z t frame time pi`, `[param]` names, `+ - * / ^`, and [functions](#formulas); `time` is seconds since the first frame |
| frames | `\"1-48\"`, or one frame, `7` |
| colour | `\"#rrggbb\"`, a CSS name, or `[r, g, b]` from 0 to 1: sRGB. `{ linear = [r, g, b] }`: scene-linear Rec.709. A name of `[color]`. For a shape also formulas, `[\"x\", 0.2, \"t\"]`, and tables as below |
| shape | its name, `\"ball\"`; or one written in place, `{ sphere = 1, move = [1, 0, 0] }`, with all keys of a shape, other shapes in place among them |
| cells | their name, or `{ octree = … }` in place |
| box | an edge length or three, around the origin; or `[[least x, y, z], [greatest x, y, z]]` |
| file | relative to the scene; `$NAME` and `${NAME}` are variables of the environment, and must be set; `$$` is a dollar sign. `cube.obj`, where there is no such file beside the scene, is the built-in cube of edge 1.6; so are `logo.svg`, `leaf.png`, `relief.png` and `points.csv`, of the examples |

Lengths are in `unit`, angles in degrees; only keys in voxels say so. F is positive inside. Numbers reach from −1e15 to
1e15; one that must be greater than 0 is at least 1e-15.

**Time.** t is 0 at the first frame of `frames` and 1 at its last: t = (frame − first)/(last − first). Outside the shot
the ends hold.

**Order.** Whatever the order of the text: what the shape is, then what is done to it in the order of
[that chapter](#what-can-be-done-to-a-shape), then `scale`, `rotate`, `move`. A list gives any other order, each as often as it is wanted:
`do = [{ twist = 30 }, { move = [1, 0, 0] }, { twist = 30 }]`.

**Distances.** `offset`, `shell`, `displace`, `bands`, `blend_radius` and `seam` are distances. Where a shape's F is not
the distance on the side that they use, the distance is measured first, which takes from a tenth of a second to some
seconds, for a shape that changes in every frame. F is the distance where it is given as the signed distance or as a
length in [nodes.md](nodes.md), outside of unions of such shapes, and inside what is cut from them. What has no end cannot be measured: give it
`bounds`. Shapes of the plane are measured in the plane. Of a blend of three, what the first two make counts by its F. `distance` on the shape says by what it is measured, and
[accuracy.md](accuracy.md) how right that is.

**The plane.** `circle`, `polygon`, `star` and others are shapes of the xy plane. `extrude`, `revolve` and `sweep` make
solids of them, and `lathe` turns a polygon. Set operations and blends of shapes of the plane are of the plane; among solids
such a shape is an error. Move, turn and scale it within the plane. Baked by itself it is extruded by an eighth of its longer
side, with a warning. A `[morph]` between shapes of the plane goes on in the plane, as the papers' do, with their distances there,
and is extruded by its `height`; its `rotate` and `move` turn and move the solid. A shape made by `morph` of two such is of the
plane, too. What waits by `delay` goes by x and y. In `mode = \"openvdb\"` both shapes are extruded first.

**Output.** hfvdb bakes the `[morph]` if there is one, otherwise `output.shape`, otherwise the only shape that no other
shape uses.

**Limits.** Shapes in place stand at most 64 deep in one another (in TOML, whose reader counts keys and brackets, 42 where
each stands in a list), shapes are made of shapes at most 200 levels deep and of a million in all, each counted as often as
it is used, and a scene has at most 16 MiB. A scene is a file: a pipe is refused.

**Errors** name file, line and column, mark the text and propose the nearest name, or list what there is; all of a scene
come together. [These](mistakes.md) are easily made.
";

const FORMULAS: &str = "
## Formulas

`-1.3 + 0.2*sin(2*pi*t)`: numbers (`2`, `.5`, `1e-3`), names, `+ - * /`, `^` for powers, parentheses, and the functions
below. `^` binds tightest and to the right: `-x^2` is −(x²). There is no product without `*`. `<`, `<=`, `>`, `>=`, `==` and
`!=` compare, bind loosest, and give 1 or 0; they jump. Of places, ask for `abs(x - 0.1) < 0.01`
rather than `x == 0.1`, which hardly any voxel meets. Names are `x y z` (places, in
formulas of space alone), `t`, `frame`, `time` (seconds since the first frame), `pi`, and those of `[param]`. Angles in
formulas are in **radians**, unlike those of `rotate`: degrees times `pi/180`.

Division by 0 is infinite, and 0/0, roots and logarithms of negative numbers and powers of negative numbers that are not
whole are not a number. A number over time must be finite in every frame, a colour or attribute a number where the surface is, and
a shape's formula wherever the shape is looked for, in its `bounds` and around them: else an error names frame and place.
Keep arguments in range, as in `sqrt(max(x, 0))`. Functions that jump make a surface where they do.

`dist('ball')` in a formula of a shape's space is the distance of another shape where it stands, positive inside, measured
first where that shape's F is none (for a colour or attribute, in and around the box of its own shape and that shape's; further
away it is right to a few hundredths); `attr('rib')` is an attribute of the shape itself, see
[below](#names-in-formulas-let-attributes).

| function | what it gives |
|---|---|
";

const OPERATIONS: &str = "\
```toml
[operation.melt]
fields = [\"a\", \"b\"]
param.w = { value = 0.25, min = 0.001, text = \"how far they flow together\" }
formula = \"max(a, b) + max(w - abs(a - b), 0)^2/(4*w)\"
rises_in = [\"a\", \"b\"]
lipschitz = 1

[shape.both]
melt = [\"cube\", { sphere = 1 }]
w = 0.4
```

The operation's name is a key of shapes, its parameters are keys beside it; neither may be the name of a node. F of the whole is
the formula of the shapes' F where they stand. Colours and attributes go along as those of `blend`, by weights that add up to
1, and so does motion. `rises_in` and `lipschitz` are checked by samples of the fields from −100 to 100, with the numbers of
each shape; where one is not kept, the error names the fields' values.";

const SHAPES: &str = "
## `[shape.NAME]`: what a shape is

A shape has exactly one of these keys, and beside it the parameters that [nodes.md](nodes.md) lists with it.

";

const MODIFIERS: &str = "
## What can be done to a shape

In this order, whatever the order of the text.

";

const COLOURS: &str = "
## Colours as tables

A colour written as a table has exactly one of these keys. `color = [\"0.5 + x\", 0.2, \"t\"]` is three sRGB numbers, of
which any may be a formula of `x y z t frame time pi` and `[param]` names, or keys; formulas are held to 0 … 1. Space is
the shape's own: after copies in cells (`at`), inside each of other copies (`array`, `polar`, …), before bends (`twist`,
`bend_along`, `wrap_cylinder`, …), so that colours go along with them, and before `scale`, `rotate` and `move`. Colours in the
space of what comes of it are those of a shape around it: `union` of it alone, with a `color`. A formula that is not a number where its colour
is needed is an error that names the place. Names of `[color]` and palettes hold plain colours only.

";

const KEY: &str = "\
`{ 1 = 0, 24 = { value = 0.5, out = [6, 0.3] }, 48 = 1, ease = \"bezier\" }`: with `ease = \"bezier\"` the keys are joined
by one smooth curve that never goes beyond two neighbouring keys, is level at its first key, its last and wherever it
turns (as Blender's auto-clamped handles), and can be bent by handles. A handle reaches to the neighbouring key at most.";
const SCALARS: &str = "
## `attribute`: numbers that go with the surface

`attribute.NAME = …` gives a shape a number of any name, such as roughness or density. It is a number, keys, a formula of
`x y z t frame time pi` and `[param]` names, or a table with exactly one of the keys below; space is that of formulas of
colours. Each becomes a float grid of its name on the voxels of `surface`, with the value at the surface point closest to
the voxel. Attributes go through unions, blends, cuts and morphs by the weights of colours; a part without the attribute
counts as 0.

None of them moves the surface, not even one that is called `displacement`, unless `displace` names it. Then F = f + d,
with the signed distance f (measured first where the shape's F is none) and the attribute d at the same point, not at the
surface point nearest to it; where d jumps, so does the surface. d needs a greatest value near the shape, or is refused:
`\"min(…, 0.1)\"` gives it one. Colours, bands of depth and other attributes stay where they are, and the surface goes
through them. In a morph a shape's own `displace` comes before the morph, and `[morph] displace` after it.

";

const MODES: &str = "\nModes, each with keys of its own beside these: ";

const FILL: &str = "\
Of each frame what lies in the mixture of two structures stays: min(F, (1 − ω)·a + ω·b). Weights of 0 and 1 are the
structures themselves; ω may go beyond. F of the structures need not be a distance; alike in steepness they mix evenly.";

const ROUND: &str = "\
Each object is cut in time by a plane: the first at t = 0, the second at t = 1. This blends each with its plane before
the two are joined.";

const NAMES: &str = "
## Names in formulas: `let`, attributes

```toml
[shape.vase]
let.r = \"sqrt(x^2 + y^2)\"
let.belly = \"0.6 + 0.2*sin(2*z)\"
attribute.rib = \"0.5 + 0.5*cos(12*atan2(y, x))\"
formula = \"belly + 0.03*rib - r\"
bounds = [2, 2, 2]
color = [\"rib\", 0.4, \"1 - rib\"]
```

A shape's `let` gives its formulas names, each for a formula, a number or keys, of one another in any order. So does each of its
attributes; one that is a table, such as `{ interior = [\"tip\"] }`, only in colours and attributes, not in what makes the
shape; `attr('rib')` is the same as `rib`. Where an
attribute has the name of a parameter, the parameter is meant. Numbers of the shape know those names that do not hang on the
place. A shape in place has its own names, and not those of the shape around it.
";

const IMPORTS: &str = "
## Scenes of several files

```toml
import.props = \"lib/props.toml\"

[shape.shelf]
union = [\"props/glass\", { difference = [{ box = 1 }, \"props/knob\"] }]
color = \"props/oak\"
```

A file that is imported brings its parameters, palettes, colours, cells, operations and shapes, each with the import's name and
a `/` before its own. Within that file names, parameters and paths mean what they mean there. All else in it (`frames`,
`[morph]`, `[output]`, variants) is about itself as a scene; numbers are taken as they are, with a warning where `unit` or `up`
differ. Files may import files, at most 256 in all; `--set props/size=3` sets a parameter of one. The scene's hash, and with it
`--resume` and the cache, follows the content of all.
";

const OVERRIDES: &str = "
## Parameters, variants, `--set`

```toml
[param]
size = 2                                        # for formulas: sphere = \"size/2\"
bend = { value = 0.3, min = 0, max = 1, text = \"how far it leans\" }

[variant.wide]                                  # hfvdb bake SCENE --variant wide
shape.cube.box = [3, 1.6, 1.6]
```

`--set size=3` sets a parameter, `--set fps=25` a key at the top, `--set morph.bridge=1` any dotted key. A variant's
dotted keys replace single values; a table in braces replaces the whole value.
";

const PICTURES: &str = "
`hfvdb preview cube-to-heart` and, below, `hfvdb preview cube-to-heart --variant rgb`:

![The contact sheet of cube-to-heart, mixed in HSV](images/cube-to-heart.png)
![The contact sheet of its variant rgb](images/cube-to-heart-rgb.png)
";

/// The text of `docs/scene.md`.
pub fn reference() -> String {
    let mut out = String::from(BEGINNING);
    out.push_str(FORMULAS);
    for (_, usage, text) in functions() {
        let _ = writeln!(out, "| `{usage}` | {text} |");
    }
    section(&mut out, "The top of a scene", "", keys::SCENE);
    out.push_str(SHAPES);
    names(&mut out, "MAKERS");
    out.push_str(MODIFIERS);
    names(&mut out, "MODIFIERS");
    section(&mut out, "Every shape", "Beside what it is and what is done to it.", keys::SHAPE);
    section(&mut out, "`distance` as a table", "", keys::ADF);
    section(&mut out, "`bounds` as a table", "", keys::BOUNDS);
    section(&mut out, "`at`: copies", "", keys::COPIES);
    section(&mut out, "`[cells.NAME]`", "", keys::CELLS);
    section(&mut out, "`[operation.NAME]`: operations of your own", OPERATIONS, keys::OPERATION);
    out.push_str(COLOURS);
    names(&mut out, "COLOURS");
    out.push_str(SCALARS);
    names(&mut out, "SCALARS");
    section(&mut out, "A key as a table", KEY, keyframes::KEY);
    section(&mut out, "`[param]`: a parameter as a table", "", keys::PARAMETER);
    section(&mut out, "`[morph]`", "", keys::MORPH);
    out.push_str(MODES);
    names(&mut out, "MODES");
    section(&mut out, "`delay` of `[morph]` as a table", "", keys::DELAY);
    section(&mut out, "`fill` of `[morph]`", FILL, keys::FILL);
    section(&mut out, "`round` of `[morph]`", ROUND, keys::ROUND);
    section(&mut out, "`[output]`", "The command line's options come before these.", keys::OUTPUT);
    out.push_str(NAMES);
    out.push_str(IMPORTS);
    out.push_str(OVERRIDES);
    out.push_str("\n## Built-in scenes\n\n");
    for name in builtin_names() {
        let _ = writeln!(out, "- `{name}`: {}", builtin_line(name).unwrap_or_default());
    }
    out.push_str(PICTURES);
    out
}

fn section(out: &mut String, title: &str, text: &str, keys: &[Key]) {
    let _ = write!(out, "\n## {title}\n\n");
    if !text.is_empty() {
        let _ = write!(out, "{text}\n\n");
    }
    table_of(out, keys.iter());
}

/// The nodes of a table by their names, each a link to what [`super::catalogue`] says of it.
fn names(out: &mut String, table: &str) {
    let mut met: Vec<&str> = Vec::new();
    for (of, group, names) in list::ROOMS {
        let mut links = Vec::new();
        for name in *names {
            // Headings of one name are told apart by a number from the second on.
            let before = met.iter().filter(|other| *other == name).count();
            let number = if before == 0 { String::new() } else { format!("-{before}") };
            links.push(format!("[`{name}`](nodes.md#{name}{number})"));
            met.push(name);
        }
        if *of == table {
            let _ = writeln!(out, "- {group}: {}", links.join(", "));
        }
    }
}

#[cfg(test)]
mod tests {
    /// `UPDATE_DOCS=1 cargo test` writes the page anew.
    #[test]
    fn the_page_is_what_the_tables_say() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/scene.md");
        if std::env::var_os("UPDATE_DOCS").is_some() {
            std::fs::write(path, super::reference()).unwrap();
        }
        let page = std::fs::read_to_string(path).unwrap();
        assert!(page == super::reference(), "docs/scene.md is out of date: UPDATE_DOCS=1 cargo test the_page");
    }
}
