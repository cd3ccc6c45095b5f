//! Scenes of several files.

use std::fs;
use std::path::Path;

use super::{Source, load};
use crate::node::model::Model;
use crate::text::{Diagnostics, Overrides};

/// Loads the first of some files, with what `--set` changes.
fn loaded(files: &[(&str, &str)], set: &[&str]) -> Result<Model, Diagnostics> {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap_or(Path::new("."))).expect("a folder");
        fs::write(path, text).expect("a file");
    }
    let set = set.iter().map(|set| (*set).to_owned()).collect();
    load(&Source::Path(folder.path().join(files[0].0)), &Overrides { set, variant: None })
}

/// Every message as `file:line:column message; help`, without the folder.
fn problems(files: &[(&str, &str)]) -> Vec<String> {
    let problems = match loaded(files, &[]) {
        Ok(model) => model.warnings,
        Err(problems) => problems,
    };
    let file = |path: &str| path.rsplit('/').next().unwrap_or_default().to_owned();
    let line = |diagnostic: &crate::text::Diagnostic| {
        let place = problems
            .place(diagnostic)
            .map_or(String::new(), |at| format!("{}:{}:{} ", file(&at.file), at.line, at.column));
        format!("{place}{}; {}", diagnostic.message, diagnostic.help)
    };
    problems.list().iter().filter(|diagnostic| diagnostic.severity != crate::text::Severity::Note).map(line).collect()
}

const PROPS: &str = "hfvdb = 1\nimport.lamps = 'more/lamps.toml'\n[param]\nsize = 2\n[palette]\nwarm = ['red', 'rust']\n\
                     [color]\nrust = '#b7410e'\n[cells.grid]\noctree = 'glass'\n[operation.melt]\nfields = ['a', 'b']\n\
                     formula = 'max(a, b)'\n[shape.glass]\ndifference = ['block', { sphere = 'size/4' }]\ncolor = 'rust'\n\
                     [shape.block]\nbox = 'size'\n[shape.pair]\nunion = ['glass', 'lamps/bulb']\n[shape.made]\n\
                     melt = ['glass', 'block']\n[morph]\nfrom = 'glass'\nto = 'block'\n[output]\nresolution = 9\n";
const LAMPS: &str = "hfvdb = 1\n[shape.bulb]\nmesh = 'bulb.obj'\n";
const BULB: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

fn props(scene: &str) -> Vec<(&'static str, String)> {
    let text = format!("hfvdb = 1\nimport.props = 'lib/props.toml'\n{scene}");
    vec![
        ("scene.toml", text),
        ("lib/props.toml", PROPS.into()),
        ("lib/more/lamps.toml", LAMPS.into()),
        ("lib/more/bulb.obj", BULB.into()),
    ]
}

fn borrowed<'f>(files: &'f [(&'static str, String)]) -> Vec<(&'f str, &'f str)> {
    files.iter().map(|(name, text)| (*name, text.as_str())).collect()
}

fn value_of(model: &Model, shape: &str, key: &str) -> f64 {
    let shape = model.shapes.iter().find(|found| found.name == shape).expect("it is there");
    shape.arguments.vector(key).expect("a vector")[0].at(&model.moment(1.0)).expect("a number")
}

#[test]
fn names_and_paths_mean_what_they_mean_in_their_file() {
    let scene = "[param]\nsize = 7\n[shape.both]\nunion = ['props/glass', 'props/lamps/bulb', 'props/pair', 'block', { 'props/melt' = ['block', 'props/made'] }]\n\
                 [shape.block]\nbox = 'size'\n";
    let files = props(&scene.replace("'props/melt'", "\"props/melt\""));
    assert_eq!(problems(&borrowed(&files)), [] as [&str; 0]);
    let model = loaded(&borrowed(&files), &[]).expect("it is right");
    assert_eq!((value_of(&model, "block", "box"), value_of(&model, "props/block", "box")), (7.0, 2.0));
    let set = loaded(&borrowed(&files), &["props/size=3", "size=8", "shape.props/block.box=1"]).expect("it is right");
    assert_eq!((value_of(&set, "block", "box"), value_of(&set, "props/block", "box")), (8.0, 1.0));
    assert_eq!(model.moment(1.0).parameters[..], [7.0, 2.0]);
    let glass = model.shapes.iter().find(|shape| shape.name == "props/glass").expect("it is there");
    let rust = crate::text::colour::css("#b7410e");
    assert_eq!(
        glass.colour.as_ref().and_then(|colour| match colour.arguments.get("srgb") {
            Some(super::argument::Argument::Colour(colour)) => Some(*colour),
            _ => None,
        }),
        rust
    );
    assert_eq!(model.files().len(), 3, "{:?}", model.files());
}

/// What is baked, frames and output are the scene's own.
#[test]
fn one_shape_of_a_file_is_a_scene() {
    let files = props("[output]\nshape = 'props/glass'\n");
    let model = loaded(&borrowed(&files), &[]).expect("it is right");
    assert!(model.shot.still && model.output.resolution == 256);
    let files = props("[shape.a]\ndifference = ['props/glass', 'props/block']\n");
    assert_eq!(problems(&borrowed(&files)), [] as [&str; 0]);
}

#[test]
fn the_hash_follows_what_is_imported() {
    let hash = |files: &[(&'static str, String)]| loaded(&borrowed(files), &[]).expect("right").hash().expect("files");
    let mut files = props("[output]\nshape = 'props/glass'\n");
    // Without a mesh: the folder is gone when the hash is made.
    files[2].1 = "[shape.bulb]\nsphere = 0.1\n".into();
    let mut other = files.clone();
    other[1].1 = PROPS.replace("size = 2", "size = 3");
    let mut spaced = files.clone();
    spaced[1].1 = PROPS.replace("size = 2", "size  =  2.0   # edge");
    assert_eq!(hash(&files), hash(&spaced));
    assert_ne!(hash(&files), hash(&other));
    let part = |files: &[(&'static str, String)]| {
        let model = loaded(&borrowed(files), &[]).expect("right");
        let id = model.shapes.iter().position(|shape| shape.name == "props/glass").expect("it is there");
        model.part_hash(super::ShapeId(id), super::id::Stage::Placed).expect("files")
    };
    assert_eq!(part(&files), part(&spaced));
    assert_ne!(part(&files), part(&other));
}

#[test]
fn imports_that_are_wrong() {
    let scene = ("scene.toml", "hfvdb = 1\nimport.a = 'a.toml'\n[shape.s]\nunion = ['a/s']\n");
    let cases: [(&[(&str, &str)], &str); 8] = [
        (
            &[scene, ("a.toml", "[shape.s]\nsphre = 1\n")],
            "a.toml:2:1 unknown key `sphre` in `shape.a/s`; did you mean `sphere`?",
        ),
        (&[scene, ("a.toml", "[shape.s]\nunion = ['t']\n")], "a.toml:2:11 there is no `shape.t`; did you mean `s`?"),
        (&[scene, ("a.toml", "[shape.s]\nsphere = 1\n[shape.t]\n")], "a.toml:3:8 nothing says what `shape.a/t` is; "),
        (&[scene, ("a.toml", "[shape.s\n")], "a.toml:1:"),
        (
            &[scene, ("a.toml", "shap = 1\n[shape.s]\nsphere = 1\n")],
            "a.toml:1:1 unknown key `shap` at the top of a scene; did you mean `shape`?",
        ),
        (&[scene, ("b.toml", "")], "scene.toml:2:13 there is no file `a.toml`; did you mean `b.toml`?"),
        (
            &[scene, ("a.toml", "unit = 'cm'\n[shape.s]\nsphere = 1\n")],
            "scene.toml:2:13 the file has unit = \"cm\", and this scene \"m\"; its numbers",
        ),
        (
            &[("scene.toml", "hfvdb = 1\nimport = 3\n[shape.s]\nsphere = 1\n")],
            "scene.toml:2:10 `import` must be a table of files; ",
        ),
    ];
    for (files, wanted) in cases {
        let found = problems(files);
        assert!(found.iter().any(|found| found.starts_with(wanted)), "{wanted}\n{found:#?}");
    }
    let found = problems(&[
        scene,
        ("a.toml", "import.b = 'b.toml'\n[shape.s]\nsphere = 1\n"),
        ("b.toml", "import.a = 'a.toml'\n"),
    ]);
    assert!(
        found.len() == 1 && found[0].starts_with("b.toml:1:13 `") && found[0].contains("` imports itself; the way is "),
        "{found:#?}"
    );
    let found = problems(&[scene, ("a.toml", "import.b = 'scene.toml'\n[shape.s]\nsphere = 1\n")]);
    assert!(found.iter().any(|found| found.starts_with("a.toml:1:13 ")), "{found:#?}");
    // Two of each file in each: as many as there may be, and no more.
    let twice = |next: usize| format!("import.a = 'f{next}.toml'\nimport.b = 'f{next}.toml'\n");
    let files: Vec<(String, String)> = (0..40).map(|i| (format!("f{i}.toml"), twice(i + 1))).collect();
    let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    let found = problems(&files);
    assert!(found.iter().any(|found| found.contains("a scene imports at most 256 files")), "{found:#?}");
}
