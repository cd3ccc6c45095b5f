//! Scenes that are right, and scenes that are wrong in every way there is.

use std::path::PathBuf;
use std::sync::Arc;

use super::*;
use crate::node::load::load_with;
use crate::text::source;
use crate::text::*;

fn load_text(text: &str, overrides: &Overrides) -> Result<Model, Diagnostics> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes"));
    let name = if text.trim_start().starts_with('{') { "scene.json" } else { "scene.toml" };
    let source = Source::Text { name: name.into(), text: text.into(), folder };
    load_with(&source, overrides, Arc::new(|name| (name == "SHOT").then(|| "/shots/010".into())))
}

pub(super) fn model(text: &str) -> Model {
    load_text(text, &Overrides::default()).unwrap_or_else(|problems| panic!("{problems}"))
}

/// Every message as `line:column message; help`.
fn problems_with(text: &str, overrides: &Overrides) -> Vec<String> {
    let problems = match load_text(text, overrides) {
        Ok(model) => model.warnings,
        Err(problems) => problems,
    };
    let line = |diagnostic: &Diagnostic| {
        let place = problems.place(diagnostic).map_or(String::new(), |at| format!("{}:{} ", at.line, at.column));
        let help = if diagnostic.help.is_empty() { String::new() } else { format!("; {}", diagnostic.help) };
        format!("{place}{}{help}", diagnostic.message)
    };
    problems.list().iter().filter(|diagnostic| diagnostic.severity != Severity::Note).map(line).collect()
}

pub(super) fn problems(text: &str) -> Vec<String> {
    problems_with(text, &Overrides::default())
}

/// The one problem of a scene that is otherwise right.
#[track_caller]
pub(super) fn only(text: &str, wanted: &str) {
    assert_eq!(problems(text), [wanted], "of:\n{text}");
}

fn shape<'m>(model: &'m Model, name: &str) -> &'m Shape {
    model.shapes.iter().find(|shape| shape.name == name).expect("the test's scene has it")
}

#[test]
fn unknown_keys_get_the_nearest_name() {
    only("[shape.a]\nsphere = 1\nmoev = [1, 0, 0]\n", "3:1 unknown key `moev` in `shape.a`; did you mean `move`?");
    only("[shape.a]\nsphre = 1\n", "2:1 unknown key `sphre` in `shape.a`; did you mean `sphere`?");
    only("seeds = 3\n[shape.a]\nsphere = 1", "1:1 unknown key `seeds` at the top of a scene; did you mean `seed`?");
    only("[shape.a]\nsphere = 1\nheight = 2\n", "3:1 unknown key `height` in `shape.a`; `height` goes with `cylinder`");
    only(
        "[shape.a]\nsphere = 1\nscale.x = 2\n",
        "3:7 `x` is not a frame; keys are `{ frame = value, ease = \"smooth\" }`",
    );
}

#[test]
fn a_shape_has_one_maker() {
    only(
        "[shape.a]\nsphere = 1\nbox = 2\n",
        "3:1 `sphere` and `box` both say what `shape.a` is; a shape has one maker; `union` and its kin join several shapes",
    );
    let none = problems("[shape.a]\nmove = [0, 0, 1]\n");
    assert_eq!(none.len(), 1);
    assert!(none[0].starts_with("1:8 nothing says what `shape.a` is; give it one of `sphere`, `box`"), "{none:?}");
}

/// An unknown maker, or two of them, hide nothing else of their table.
#[test]
fn all_errors_of_a_shape_come_together() {
    let rest = "move = [1, 2]\nbounds = 'wide'\ncolor = '#d72'\ncolour_ = 1\nattribute.rough = 'sni(x)'\n";
    for (maker, first) in [
        ("blobs = 3", "2:1 unknown key `blobs` in `shape.a`; there is `sphere`, `box`, "),
        ("sphere = 1\nbox = 2", "3:1 `sphere` and `box` both say what `shape.a` is"),
    ] {
        let found = problems(&format!("[shape.a]\n{maker}\n{rest}"));
        let parts = [
            first,
            "`shape.a.move` must be three numbers",
            "`shape.a.bounds` must be a box",
            "unknown key `colour_` in `shape.a`; did you mean `color`?",
            "there is no function `sni`; did you mean `sin`?",
        ];
        assert_eq!(found.len(), parts.len(), "{found:#?}");
        for (found, part) in found.iter().zip(parts) {
            assert!(found.contains(part), "{part}: {found}");
        }
    }
}

/// Where no name is near, all that there are are listed; all errors of a formula are told.
#[test]
fn what_there_is_is_listed() {
    let found = problems("[shape.a]\nformula = 'wibble(x) + bar - wobble'\n");
    assert_eq!(found.len(), 3, "{found:#?}");
    assert!(found[0].starts_with("2:12 there is no function `wibble`; there are `abs`, `angle`, "), "{found:#?}");
    assert!(found[1].starts_with("2:24 nothing here is called `bar`; known are "), "{found:#?}");
    assert!(found[2].starts_with("2:30 nothing here is called `wobble`"), "{found:#?}");
    let names: String = (0..15).map(|i| format!("[shape.part{i}]\nsphere = 1\n")).collect();
    let found = problems(&format!("{names}[shape.z]\nunion = ['wheel']\n[output]\nshape = 'z'\n"));
    assert!(found[0].contains("there is no `shape.wheel`; there is `part0`, `part1`, "), "{found:#?}");
    assert!(found[0].contains("`part9` and `z`"), "{found:#?}");
    let found = problems("[shape.a]\nsphere = 1\n[output]\nshape = 'a'\nqqq = 1\n");
    assert!(found[0].contains("unknown key `qqq` in `output`; there is `shape`, `voxel_size`"), "{found:#?}");
}

#[test]
fn wrong_types_and_ranges() {
    only("[shape.a]\nsphere = true\n", "2:10 `shape.a.sphere` must be a number, a formula or keys");
    only("[shape.a]\nsphere = -1\n", "2:10 `shape.a.sphere` must be greater than 0");
    only("[shape.a]\nsphere = inf\n", "2:10 `shape.a.sphere` must be greater than 0");
    only("[shape.a]\nbox = [1, 2]\n", "2:7 `shape.a.box` must be three numbers");
    only("[shape.a]\nbox = [1, 2, -3]\n", "2:14 `shape.a.box.z` must be greater than 0");
    only(
        "[shape.a]\nsphere = {}\n",
        "2:10 `shape.a.sphere` has no keys; keys are `{ frame = value, ease = \"smooth\" }`",
    );
    only(
        "[shape.a]\nsphere = { 1 = 1, 9 = 2, ease = \"smoth\" }\n",
        "2:34 `shape.a.sphere.ease` cannot be `smoth`; did you mean `smooth`?",
    );
    only(
        "frames = \"48-1\"\n[shape.a]\nsphere=1",
        "1:11 `frames` must be frames such as \"1-48\": this runs backwards",
    );
    only(
        "unit = \"parsec\"\n[shape.a]\nsphere=1",
        "1:9 `unit` cannot be `parsec`; there is `m`, `cm`, `mm`, `km`, `in` and `ft`",
    );
    let morph = |line: &str| {
        format!("frames='1-9'\n[shape.a]\nsphere=1\n[shape.b]\nbox=1\n[morph]\nfrom='a'\nto='b'\n{line}\n")
    };
    only(&morph("alpha = -0.1"), "9:9 `morph.alpha` must be 0 or greater");
    only(&morph("beta = 1.5"), "9:8 `morph.beta` must be from 0 to 1");
    only("hfvdb = 2\n[shape.a]\nsphere=1", "1:9 `hfvdb` must be from 1 to 1");
    only("[shape]\na = 3\n", "2:5 `shape.a` must be a table");
    only("shape = 3\n", "1:9 `shape` must be a table");
    only(
        "[shape.a]\nsphere=1\nbounds=[[0,0,0],[1,0,1]]\n",
        "3:8 `shape.a.bounds` must be a box; an edge length, three edge lengths, or [[least x, y, z], [greatest x, y, z]], of at most 1e15",
    );
    only(
        "[shape.a]\nsphere=1\n[output]\nvoxel_size=0.1\nresolution=64",
        "4:1 `voxel_size` and `resolution` say the same thing twice",
    );
    only(
        "[shape.a]\nsphere=1\n[output]\nhalf=['Cd', 'surfaces']\n",
        "4:14 `output.half` cannot be `surfaces`; did you mean `surface`?",
    );
    only("[shape.a]\nsphere=1\ncolor='red'\ncolour='red'\n", "4:1 `color` and `colour` are the same key");
}

#[test]
fn names_that_point_nowhere() {
    only(
        "[shape.ball]\nsphere=1\n[shape.b]\nunion=['bal']\n[output]\nshape='b'",
        "4:9 there is no `shape.bal`; did you mean `ball`?",
    );
    only(
        "[cells.c]\noctree='m'\n[shape.m]\nmesh='cube.obj'\n[shape.f]\nfacet='c'\ncells='c'\n",
        "6:8 there is no `shape.c`; `c` is the name of cells",
    );
    only(
        "[cells.c]\noctree='m'\n[shape.m]\nmesh='cube.obj'\n[shape.f]\nfacet='m'\ncells='c'\ncolor={palette='p'}",
        "8:17 there is no `palette.p`",
    );
    only("[shape.m]\nmesh='cub.obj'\n", "2:7 there is no file `cub.obj`; did you mean `cube.obj`?");
    only(
        "[shape.m]\nmesh='$SHOTS/cube.obj'\n",
        "2:7 the variable `$SHOTS` is not set; variables are those of the environment; `$$` is a dollar sign",
    );
    only(
        "[shape.m]\nmesh='$SHOT/cube.obj'\n",
        "2:7 there is no file `/shots/010/cube.obj`; there is no folder `/shots/010`",
    );
    only("[shape.m]\nmesh='../scenes'\n", "2:7 `../scenes` is a folder, not a file");
    let overrides = Overrides { variant: Some("rbg".into()), ..Overrides::default() };
    assert_eq!(
        problems_with("[shape.a]\nsphere=1\n[variant.rgb]\nfps=25", &overrides),
        ["the scene has no variant `rbg`; did you mean `rgb`?"]
    );
    let missing = load(&Source::of_argument("cubsim"), &Overrides::default()).unwrap_err();
    assert_eq!(
        missing.to_string(),
        "error: there is no scene `cubsim`\n |\n = help: did you mean the built-in scene `cubism`?"
    );
}

#[test]
fn cycles_show_their_way() {
    only(
        "[shape.a]\nunion = ['b']\n[shape.b]\nunion = ['c', 'd']\n[shape.c]\nintersection = ['a']\n[shape.d]\nsphere=1\n",
        "2:11 `a` is made from itself; the way is a → b → c → a",
    );
    only("[shape.a]\nunion = ['a']\n", "2:11 `a` is made from itself; the way is a → a");
    only(
        "[shape.e]\nsphere=1\n[shape.a]\nmesh='cube.obj'\nat={cells='c'}\n[cells.c]\noctree='a'\n[output]\nshape='e'\n",
        "5:12 `a` is made from itself; the way is a → c → a",
    );
}

#[test]
fn what_is_output() {
    let one = "[shape.a]\nsphere=1\n[shape.b]\nbox=1\n[shape.c]\nunion=['a','b']\n";
    let model = model(one);
    assert!(matches!(model.content, Content::Shape(id) if model.shape(id).name == "c"));
    only(
        "[shape.a]\nsphere=1\n[shape.b]\nbox=1\n",
        "3:8 what is to be baked, `a` or `b`?; join them, or name one: [output] with shape = \"…\"",
    );
    only("seed = 1\n", "the scene has no shape; [shape.ball] with sphere = 1");
    let chosen = self::model(&format!("{one}[output]\nshape='b'\n"));
    assert!(matches!(chosen.content, Content::Shape(id) if chosen.shape(id).name == "b"));
    let morph = "frames='1-9'\n[shape.a]\nsphere=1\n[shape.b]\nbox=1\n[morph]\nfrom='a'\nto='b'\n";
    assert!(matches!(self::model(morph).content, Content::Morph(_)));
    only(&format!("{morph}[output]\nshape='b'\n"), "10:8 `output.shape` is not used: the morph is what is baked");
    only(&morph.replace("frames='1-9'", ""), "6:2 a morph needs the scene's `frames`; such as frames = \"1-48\"");
    only(&format!("{morph}a1 = 2\n"), "9:1 `a1` is for `mode = \"paper\"` only");
    only(&format!("{morph}mode='paper'\nbridge = 2\n"), "10:1 `bridge` is for `mode = \"volume\"` only");
}

#[test]
fn many_errors_stay_within_two_kilobytes() {
    let mut text = String::from("[shape.a]\nsphere = 1\n");
    for i in 0..40 {
        text.push_str(&format!("wrong_number_{i} = \"{}\"\n", "long ".repeat(60)));
    }
    let problems = load_text(&text, &Overrides::default()).unwrap_err();
    let report = problems.render(false);
    assert!(report.len() <= 2048, "{} bytes", report.len());
    let told = report.matches("unknown key").count();
    assert!(told >= 8, "{report}");
    assert!(report.ends_with(&format!("and {} more\n", 40 - told)), "{report}");
    assert!(report.contains("3:1"));
    let hostile = format!("[shape.\"{}\"]\nsphere = 1\n\"{}\" = 1\n", "x".repeat(5000), "y".repeat(5000));
    assert!(load_text(&hostile, &Overrides::default()).unwrap_err().render(false).len() <= 2048);
    // One alone is never only counted, whatever is in it.
    for long in ["z".repeat(9000), "\u{1b}".repeat(9000), "ö→".repeat(3000)] {
        let problem = Diagnostic::error(Span::new(0, 0..1), format!("first {long} last")).help(long);
        let mut sources = source::Sources::default();
        sources.add("a.toml", "a = 1");
        let report = Diagnostics::new(vec![problem], Arc::new(sources)).render(false);
        assert!(report.len() <= 2048 && report.contains("a.toml:1:1"), "{report}");
        assert!(report.contains("first ") && report.contains(" last") && !report.contains("more"), "{report}");
    }
    // What is short is marked and coloured.
    let short = load_text("[shape.a]\nspher = 1\n", &Overrides::default()).unwrap_err();
    assert!(short.render(true).contains('\u{1b}') && !short.render(false).contains('\u{1b}'));
}

#[test]
fn an_error_marks_its_text() {
    let problems = load_text("[shape.a]\nsphere = 1\nmoev = [1, 0, 0]\n", &Overrides::default()).unwrap_err();
    let wanted = "\
error: unknown key `moev` in `shape.a`
 --> scene.toml:3:1
  |
3 | moev = [1, 0, 0]
  | ^^^^
  |
  = help: did you mean `move`?";
    assert_eq!(problems.to_string(), wanted);
}

#[test]
fn texts_that_are_no_scene() {
    only("[shape.a\nsphere = 1\n", "1:9 not TOML: expected a right bracket, found a newline");
    only(
        "[shape.a]\nsphere = ball\n",
        "2:10 not TOML: invalid TOML value, did you mean to use a quoted string?; text stands in quotes",
    );
    // Frames with a point, which TOML takes for tables.
    only(
        "[shape.a]\nsphere = {1 = 0, 12 = 1, 12.5 = 2}\n",
        "2:26 not TOML: dotted key attempted to extend non-table type; a point in a key opens a table; a key with a point \
         of its own stands in quotes: \"12.5\"",
    );
    only(
        "[shape.a]\nsphere = {1 = 1, 12.5 = 2}\n",
        "2:21 unknown key `5` in `shape.a.sphere.12`; a key with a point stands in quotes: \"12.5\"",
    );
    only("{\"shape\": {\"a\": {\"sphere\": }}}", "1:28 not JSON: expected value");
    only("{\"shape\": {\"a\": {\"sphere\": null}}}", "1:28 null stands for nothing here; leave the key out");
    for hostile in ["[", "\u{0}", "a.b.c.d = {", "=", "[[shape]]", "shape = [[[[[[[]]]]]]]", "[shape.a]\nsphere = nan"]
    {
        assert!(load_text(hostile, &Overrides::default()).is_err(), "{hostile:?}");
    }
}

#[test]
fn json_is_the_same_scene() {
    let toml = model(
        "frames = \"1-9\"\nseed = 2\n[shape.a]\nbox = [1, 2.5, 3]\ncolor = \"red\"\nmove = [{1 = 0, 9 = 1}, 0, 0]\n",
    );
    let json = model(
        r#"{"frames": "1-9", "seed": 2, "shape": {"a": {"box": [1, 2.5, 3], "color": "red", "move": [{"1": 0, "9": 1}, 0, 0]}}}"#,
    );
    assert_eq!(toml.hash().unwrap(), json.hash().unwrap());
    only(
        "{\n \"shape\": {\"a\": {\"sphere\": 1,\n  \"moev\": 1}}}",
        "3:4 unknown key `moev` in `shape.a`; did you mean `move`?",
    );
    only("{\"shape\": {\"a\": {\"sphere\": 1, \"sphere\": 2}}}", "1:32 not JSON: duplicate key: `sphere`");
}

#[test]
fn variants_and_set_override() {
    let text = "[param]\nsize = 2\nwidth = { value = 1, range = [0, 3] }\n[shape.a]\nbox = [1, 2, 3]\ncolor = \"red\"\n\
                [variant.big]\nshape.a.box = 5\nfps = 25\n[variant.dotted]\n\"shape.a.color\" = \"blue\"\n";
    let plain = model(text);
    let with = |variant: Option<&str>, set: &[&str]| {
        let overrides =
            Overrides { variant: variant.map(str::to_owned), set: set.iter().map(|&set| set.into()).collect() };
        load_text(text, &overrides).unwrap_or_else(|problems| panic!("{problems}"))
    };
    let edges = |model: &Model| {
        shape(model, "a").arguments.vector("box").unwrap().clone().map(|edge| edge.as_constant().unwrap())
    };
    let big = with(Some("big"), &[]);
    assert_eq!((edges(&plain), edges(&big)), ([1.0, 2.0, 3.0], [5.0; 3]));
    assert_eq!(big.shot.fps, 25.0);
    let blue = with(Some("dotted"), &[]);
    let colour = shape(&blue, "a").colour.as_ref().unwrap().arguments.get("srgb").unwrap();
    assert!(matches!(colour, argument::Argument::Colour([0.0, 0.0, 1.0])));
    let set = with(Some("big"), &["size=3", "width=2", "shape.a.box=[7, 8, 9]", "unit=cm"]);
    assert_eq!(set.moment(1.0).parameters.as_ref(), [3.0, 2.0]);
    assert_eq!(edges(&set), [7.0, 8.0, 9.0]);
    let origin = |name: &str| set.settings.iter().find(|setting| setting.name == name).unwrap().origin;
    assert_eq!(
        ["shape.a.box", "fps", "shape.a.color", "seed"].map(origin),
        [Origin::Set, Origin::Variant, Origin::Scene, Origin::Default]
    );
    let in_braces = with(None, &["output.distance={ adf = 7 }", "shape.a.distance={ adf = 8 }"]);
    assert_eq!(in_braces.written_distance().depth, Some(7));
    assert_eq!(shape(&in_braces, "a").distance.depth, Some(8));
    let bad = |set: &str| problems_with(text, &Overrides { set: vec![set.into()], variant: None });
    assert_eq!(bad("sizes=3"), ["1:1 there is no parameter `sizes`; did you mean `size`?"]);
    assert_eq!(bad("fsp=3"), ["1:1 there is no parameter `fsp`; there is `size` and `width`"]);
    assert_eq!(bad("size"), ["--set `size` has no `=`: it is name=value"]);
    assert_eq!(bad("width=4"), ["1:7 `param.width` must be from 0 to 3, and is 4"]);
    assert_eq!(bad("shape.a.bxo=4"), ["1:9 unknown key `bxo` in `shape.a`; did you mean `box`?"]);
}

#[test]
fn keys_and_easing() {
    let model = model(
        "frames='1-49'\n[shape.a]\nsphere = { 1 = 1, 9 = 3 }\nmove = [{ 1 = 0, 49 = 90, ease = \"smooth\" }, { 1 = 0, 49 = 8, ease = 'in' }, { 1 = 5, 25 = 7, ease = \"hold\" }]\n",
    );
    let shape = shape(&model, "a");
    let at = |number: &Number, frame: f64| number.at(&model.moment(frame)).unwrap();
    let radius = shape.arguments.number("sphere").unwrap();
    assert_eq!([1.0, 5.0, 9.0, 40.0].map(|frame| at(radius, frame)), [1.0, 2.0, 3.0, 3.0]);
    let [x, y, z] = &shape.placement.translate;
    assert_eq!([1.0, 13.0, 25.0, 49.0].map(|frame| at(x, frame)), [0.0, 14.0625, 45.0, 90.0]);
    assert_eq!(at(y, 25.0), 2.0);
    assert_eq!([1.0, 24.5, 25.0].map(|frame| at(z, frame)), [5.0, 5.0, 7.0]);
}

#[test]
fn keys_that_are_wrong_are_said_with_their_place() {
    let keys = |keys: &str| format!("frames='1-49'\n[shape.a]\nsphere = {{ {keys} }}\n");
    only(
        &keys("9 = 3, 1 = 1"),
        "3:19 `shape.a.sphere`: the key at frame 1 stands after the one at 9; frames rise from key to key",
    );
    only(&keys("1 = 3, 01 = 1"), "3:19 `shape.a.sphere` has two keys at frame 1");
    only(
        &keys("1 = { value = 1, out = [4, 0] }, 9 = 2"),
        "3:16 `shape.a.sphere.1` has handles; they go with `ease = \"bezier\"`",
    );
    only(
        &keys("1 = { value = 1, out = [9, 0] }, 9 = 2, ease = 'bezier'"),
        "3:16 the handle `1.out` reaches beyond the neighbouring key; it is 8 frames away",
    );
    only(
        &keys("1 = 1, 9 = { value = 2, in = [1, 0] }, ease = 'bezier'"),
        "3:41 `shape.a.sphere.9.in` takes [frames, value], counted from the key; such as in = [-4, 0]",
    );
    only(
        &keys("1 = 1, 9 = { in = [-1, 0] }, ease = 'bezier'"),
        "3:23 `shape.a.sphere.9` has no `value`; The value at the frame.",
    );
    let curve = model(&keys("1 = 1, 9 = { value = 2, in = [-8, 0] }, ease = 'bezier'"));
    let radius = shape(&curve, "a").arguments.number("sphere").unwrap();
    let at = |frame: f64| radius.at(&curve.moment(frame)).unwrap();
    assert!(at(1.0) == 1.0 && at(5.0) > 1.6 && at(9.0) == 2.0, "{}", at(5.0));
    // What `--set` adds belongs in between.
    let overrides = Overrides { set: vec!["shape.a.sphere.5=7".into()], variant: None };
    let source = Source::Text { name: "scene.toml".into(), text: keys("1 = 1, 9 = 2"), folder: PathBuf::new() };
    let set = load(&source, &overrides).unwrap_or_else(|problems| panic!("{problems}"));
    let radius = shape(&set, "a").arguments.number("sphere").unwrap();
    assert_eq!(radius.at(&set.moment(3.0)).unwrap(), 4.0);
}

#[test]
fn a_morphs_ease_that_is_wrong() {
    let morph = |keys: &str| {
        format!("frames='1-9'\n[shape.a]\nsphere=1\n[shape.b]\nbox=1\n[morph]\nfrom='a'\nto='b'\n{keys}\n")
    };
    only(&morph("ease = 'smoth'"), "9:9 `morph.ease` cannot be `smoth`; did you mean `smooth`?");
    only(&morph("ease = { 1 = 0, 5 = 1.5, 9 = 1 }"), "9:21 `morph.ease.5` must be from 0 to 1");
    only(
        &morph("ease = { 1 = 0, 9 = 1, 5 = 0.5 }"),
        "9:24 `morph.ease`: the key at frame 5 stands after the one at 9; frames rise from key to key",
    );
    only(&morph("ease = true"), "9:8 `morph.ease` must be a number, a formula or keys");
    only(&morph("ease = 't^'"), "9:11 the formula ends where a number, name or `(` is expected");
    assert!(matches!(model(&morph("ease = 't'")).content, Content::Morph(_)));
    only(&morph("mode = 'paper'\nslab = [1, 0]"), "10:8 `morph.slab` takes two numbers, [least, greatest]");
    only(&morph("mode = 'paper'\nslab = 1"), "10:8 `morph.slab` must be two numbers, [least, greatest]");
}

#[test]
fn chains_that_are_wrong() {
    let morph = |keys: &str| {
        format!("frames='1-9'\n[shape.a]\nsphere=1\n[shape.b]\nbox=1\n[shape.c]\nbox=2\n[morph]\n{keys}\n")
    };
    only(&morph("to = 'b'"), "8:2 `morph` has no `from`; What it is at the first frame.");
    only(&morph("from = 'c'\nthrough = ['a', 'b', 'c']"), "9:1 `from` and `through` say the same thing twice");
    only(&morph("through = ['a']"), "9:11 `morph.through` must be at least two shapes, such as [\"a\", \"b\", \"c\"]");
    only(&morph("through = ['a', 'd', 'c']"), "9:18 there is no `shape.d`; did you mean `a`?");
    only(&morph("through = ['a', 'b', 'c']\nat = [1, 9]"), "10:6 `morph.at` has 2 frames for 3 shapes");
    only(&morph("through = ['a', 'b', 'c']\nat = [1, 9, 4]"), "10:13 `morph.at` must rise from shape to shape");
    only(&morph("through = ['a', 'b', 'c']\nat = [1, 4.5, 9]"), "10:10 `morph.at` must be whole frames");
    only(&morph("from = 'a'\nto = 'b'\nat = [1, 9]"), "11:1 `at` goes with `through`");
    only(
        &morph("through = ['a', 'b', 'c']\nease = { 1 = 0, 9 = 1 }"),
        "10:8 `morph.ease` by keys or formula is the progress of one morph, and `through` makes several; \"linear\" and \"smooth\" are of each",
    );
    only(
        &morph("through = ['a', 'b', 'c']\ncolor_over = '1-5'"),
        "10:1 `color_over` does not go with `through`; colours change from shape to shape",
    );
    only(
        &morph("through = ['a', 'b', 'c']\nat = [1, 4, 9]\nover = '1-9'"),
        "11:1 `over` and `at` say the same thing twice",
    );
    only(
        &morph("through = ['a', 'b', 'c']\nover = '1-2'"),
        "10:9 2 frames are too few for 3 shapes, one after the other",
    );
    only(
        &morph("through = ['a', 'b', 'c']\nat = [1, 4, 12]"),
        "10:6 `morph.at` reaches beyond the scene's frames, 1-9; the morph is not whole within the shot",
    );
}

#[test]
fn formulas_point_into_the_text() {
    only("[shape.a]\nsphere = \"1 + tt\"\n", "2:15 nothing here is called `tt`; did you mean `t`?");
    only("[shape.a]\nformula = \"1 - x^2 - (y^2\"\n", "2:22 this `(` is never closed");
    only(
        "[param]\nsize = 2\n[shape.a]\nformula = \"sise - x^2\"\n",
        "4:12 nothing here is called `sise`; did you mean `size`?",
    );
    only("[shape.a]\nsphere = \"1 + x\"\n", "2:15 nothing here is called `x`; known are `frame`, `t`, `time`, `pi`");
    only("[shape.a]\nsphere = 1\nmove = [0, \"sin(t\", 0]\n", "3:16 this `(` is never closed");
    only("[shape.a]\nsphere = 1\nmove = [0, '', 0]\n", "3:12 the formula is empty");
    only("[param]\nt = 2\n[shape.a]\nsphere = 1\n", "2:1 `t` already means something in formulas");
    let model = model(
        "frames='1-5'\n[param]\nsize = 3\nslow = \"t/2\"\n[shape.a]\nsphere = 1\nmove = [\"size*t\", \"frame + time\", \"cos(pi*slow)\"]\n",
    );
    let at = |i: usize, frame: f64| shape(&model, "a").placement.translate[i].at(&model.moment(frame)).unwrap();
    assert_eq!((at(0, 1.0), at(0, 3.0), at(0, 5.0)), (0.0, 1.5, 3.0));
    assert_eq!(at(1, 3.0), 3.0 + 2.0 / 24.0);
    assert!((at(2, 5.0)).abs() < 1e-15);
}

#[test]
fn a_list_gives_the_order_of_what_is_done() {
    let model = model(
        "[output]\nshape = 'a'\n[shape.a]\nbox = 1\ndo = [{ move = [1, 0, 0] }, { twist = 30 }, { twist = 10 }, { offset = 0.1 }, { rotate = [0, 0, 9] }, { move = [2, 0, 0] }]\n",
    );
    let shape = shape(&model, "a");
    let names: Vec<&str> = shape.modifiers.iter().map(|modifier| modifier.spec.key.name).collect();
    // What ends the list in the order of a placement is one.
    assert_eq!(names, ["move", "twist", "twist", "offset"]);
    let placed = |vector: &[Number; 3]| vector.each_ref().map(|number| number.at(&model.moment(1.0)).unwrap());
    assert_eq!(placed(&shape.placement.translate), [2.0, 0.0, 0.0]);
    assert_eq!(placed(&shape.placement.rotate), [0.0, 0.0, 9.0]);
    assert_eq!(placed(&shape.placement.scale), [1.0; 3]);
}

#[test]
fn a_list_of_what_is_done_that_is_wrong() {
    let text = |keys: &str| format!("[shape.a]\nbox = 1\n{keys}\n");
    only(
        &text("twist = 3\ndo = [{ move = [1, 0, 0] }]"),
        "3:1 `twist` stands beside `do` of `shape.a`; its place in the order is one in the list: { twist = … }",
    );
    only(
        &text("do = [{ twist = 3, offset = 1 }]"),
        "3:20 `twist` and `offset` are two steps of `shape.a.do[0]`; give each a table of its own",
    );
    only(
        &text("do = [{ twist = 3 }, { twits = 3 }]"),
        "3:22 nothing says what `shape.a.do[1]` does; did you mean `twist`?",
    );
    only(&text("do = { twist = 3 }"), "3:6 `shape.a.do` must be a list of tables such as { twist = 30 }");
    only(&text("do = [1]"), "3:7 `shape.a.do[0]` must be a table such as { twist = 30 }");
    only(
        &text("do = [{ offset = 1, tube = 2 }]"),
        "3:21 unknown key `tube` in `shape.a.do[0]`; `tube` goes with `torus`",
    );
    only(&text("do = [{ scale = 0 }]"), "3:17 `shape.a.do[0].scale` must be greater than 0");
}

#[test]
fn the_hash_follows_content_alone() {
    let hash = |text: &str| model(text).hash().unwrap();
    let one = hash("seed = 1\n[shape.a]\nsphere = 2 # a ball\n");
    assert_eq!(one, hash("# other words\nseed = 1\n\n[shape]\na = { sphere = 2.0 }\n[variant.x]\nseed = 3"));
    assert_ne!(one, hash("seed = 1\n[shape.a]\nsphere = 2.5\n"));
    assert_ne!(one, hash("seed = 2\n[shape.a]\nsphere = 2\n"));
    // Fixed for ever: farms compare it between releases.
    let hex: String = one.iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(hex, "aa438ee7e88eb278648982ec4afbce7bf21e14bcfb93332cd3e13cd867f1de4c");
}

#[test]
fn every_built_in_scene_is_right() {
    for name in builtin_names() {
        let scene = Source::Builtin(name.into());
        let model = load(&scene, &Overrides::default()).unwrap_or_else(|problems| panic!("{name}: {problems}"));
        assert!(model.warnings.is_empty(), "{name}: {}", model.warnings);
        assert!(builtin_text(name).unwrap().starts_with(&format!("# {name}.toml: ")), "{name}");
        assert!(builtin_line(name).is_some());
    }
}

#[test]
fn colours_that_are_wrong() {
    let colour = |colour: &str| format!("[shape.a]\nsphere = 1\ncolor = {colour}\n");
    let makers = "`linear`, `hsv`, `palette`, `range`, `checker`, `noise`, `gradient_noise`, `simplex`, `fbm`, `ridged`, `turbulence`, `worley`, `radius`, `angle`, `waves`, `stripes`, `wood`, `marble`, `curvature`, `facing`, `ramp`, `bands`, `parts`, `conformal` and `vdb`";
    only(&colour("{}"), &format!("3:9 `shape.a.color` says no colour; give it one of {makers}"));
    only(
        &colour("{ bands = [[0, 'red']], linear = [0, 0, 1] }"),
        "3:33 `bands` and `linear` both say what `shape.a.color` is",
    );
    only(&colour("{ bnads = [[0, 'red']] }"), "3:11 unknown key `bnads` in `shape.a.color`; did you mean `bands`?");
    only(
        &colour("{ bands = [[0, 'red']], seam = 1 }"),
        "3:33 unknown key `seam` in `shape.a.color`; `seam` goes with `parts`",
    );
    only(
        &colour("{ bands = [[0, 'red'], [0, 'blue']] }"),
        "3:33 `shape.a.color.bands[1]` begins at 0, not below the band before it, 0; \
         depths rise from one band to the next",
    );
    only(&colour("{ bands = ['red'] }"), "3:21 `shape.a.color.bands[0]` must be [depth, colour]");
    only(&colour("{ bands = [[0, 'rde']] }"), "3:25 `rde` is not a colour; did you mean `red`?");
    only(
        &colour("['x', 'y', 'q']"),
        "3:21 nothing here is called `q`; known are `frame`, `t`, `time`, `x`, `y`, `z`, `pi`",
    );
    only(&colour("['x', 2, 0]"), "3:15 `shape.a.color[1]` must be from 0 to 1");
    only(&colour("['x', 'y']"), "3:9 `shape.a.color` must be three numbers");
    only(&colour("{ hsv = [400, 2, 0] }"), "3:23 `shape.a.color.hsv` must be from 0 to 1");
    only(&colour("{ palette = ['red'], by = 'voxel' }"), "3:21 `shape.a.color` has no `voxel_size`; the cubes' edge");
    only(
        &colour("{ palette = ['red'], by = 'voxel', voxel_size = 0 }"),
        "3:57 `shape.a.color.voxel_size` must be greater than 0",
    );
    only(
        &colour("{ range = ['red', 'blue'] }"),
        "3:19 only a shape with `facet` or `at` has cells; \
         by = \"voxel\" with a `voxel_size` takes the cubes of a lattice",
    );
    only(
        &colour("{ range = ['red'], by = 'voxel', voxel_size = 1 }"),
        "3:19 `shape.a.color.range` must be a list of two colours",
    );
    only(&colour("{ parts = ['b'] }"), "3:21 there is no `shape.b`; did you mean `a`?");
    only(&colour("{ parts = ['a'] }"), "3:21 `a` is made from itself; the way is a → a");
    only(
        &format!("{}[color]\nx = {{ bands = [[0, 'red']] }}\n", colour("'x'")),
        "5:7 `bands` is for the `color` of a shape only",
    );
}

#[test]
fn what_a_morphs_mode_does_not_use() {
    let morph = |keys: &str| {
        format!("frames='1-9'\n[shape.a]\nsphere=1\n[shape.b]\nbox=1\n[morph]\nfrom='a'\nto='b'\n{keys}\n")
    };
    only(&morph("round = { a0 = -0.2 }"), "9:1 `round` is for `mode = \"paper\"` only");
    only(&morph("mode = 'paper'\nvolume = 2"), "10:1 `volume` is for `mode = \"volume\"` only");
    only(
        &morph("mode = 'paper'\nround = { reach = 1 }"),
        "10:9 `morph.round` has no `a0`; How much is added at the cut; a negative number takes away.",
    );
    only(
        &morph("mode = 'paper'\nround = { a0 = 1, depht = 1 }"),
        "10:19 unknown key `depht` in `morph.round`; did you mean `depth`?",
    );
    only(
        &morph("mode = 'paper'\npace = 't'"),
        "10:1 `pace` is not for `mode = \"paper\"`; it goes with `volume` and `linear`",
    );
    only(
        &morph("mode = 'union'\nease = 'smooth'"),
        "10:1 `ease` is not for `mode = \"union\"`; it goes with `volume`, `paper` and `linear`",
    );
    only(
        &morph("mode = 'still'\nover = '1-4'"),
        "10:1 `over` is not for `mode = \"still\"`; it goes with `volume`, `paper`, `linear`, `union` and `openvdb`",
    );
    only(&morph("mode = 'linear'\na0 = 1"), "10:1 `a0` is for `mode = \"paper\"` only");
    only(&morph("mode = 'paper'\na1 = -1"), "10:6 `morph.a1` must be greater than 0");
    only(&morph("volume = { 1 = 1, 5 = 0, 9 = 1 }"), "9:23 `morph.volume.5` must be from 0.001 to 100");
}

#[test]
fn copies_patterns_and_space_that_are_wrong() {
    let text = |keys: &str| format!("[shape.a]\nsphere = 1\n{keys}\n");
    only(&text("array = 0"), "3:9 `shape.a.array` must be whole numbers from 1 on: one, or three for x, y and z");
    only(
        &text("array = [9000, 9000, 9000]"),
        "3:9 `shape.a.array` makes 729000000000 copies, and 4000000 are the most",
    );
    only(
        &text("places = [[1, 2, 3], [1, 2]]"),
        "3:22 `shape.a.places[1]`: a place has 3, 4, 6 or 7 numbers, not 2; each is [x, y, z], [x, y, z, scale], [x, y, z, rx, ry, rz] or [x, y, z, rx, ry, rz, scale]",
    );
    only(
        &text("mirror = 'w'"),
        "3:11 `shape.a.mirror` cannot be `w`; one of `x`, `y`, `z`, or three numbers, such as [1, 1, 0]",
    );
    only(&text("spacing = 2"), "3:1 unknown key `spacing` in `shape.a`; `spacing` goes with `array`");
    only(&text("scatter = 9"), "1:8 `shape.a` has no `host`; The shape that they are scattered on.");
    only(&text("warp = ['x', 'y']"), "3:8 `shape.a.warp` must be three numbers");
    only(
        &text("color = { fbm = 0.5 }"),
        "3:9 `shape.a.color` has no `colors`; The colours from 0 to 1, evenly: a palette's name, or at least one.",
    );
    only(
        &text("color = { ramp = [[0, 'red'], [0, 'blue']], by = 'z' }"),
        "3:32 `shape.a.color.ramp[1]` is at 0, not after the stop before it, 0; stops rise from one to the next",
    );
    only(&text("attribute.n = 'noise(x, y)'"), "3:16 `noise` takes 3 or 4 arguments, `noise(x, y, z[, seed])`, not 2");
    only(
        &text("along = [[0, 0, 0], [1, 0, 0]]\nclosed = 'maybe'"),
        "4:11 `shape.a.closed` cannot be `maybe`; there is `no` and `yes`",
    );
    only(
        &text("warp_noise = 0.1\nscatter = 5\nhost = 'b'\nseed = 3\n[shape.b]\nbox = 1\n[output]\nshape = 'a'"),
        "6:1 `seed` of `shape.a` could go with `scatter` or with `warp_noise`; write do = [{ warp_noise = …, seed = … }]",
    );
}
