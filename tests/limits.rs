//! What is too large, too deep, too many, no file or no text: an error in little time, that says which and where.

mod support;

use std::ffi::OsStr;
use std::fmt::Write;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use support::{Run, Workplace};

/// What takes longer counts as a hang, on a busy machine too.
const PATIENCE: Duration = Duration::from_secs(10);

fn in_time(what: &str, run: impl FnOnce() -> Run) -> Run {
    let start = Instant::now();
    let run = run();
    assert!(start.elapsed() < PATIENCE, "{what}: {:?}", start.elapsed());
    run
}

fn data(name: &str) -> String {
    fs::read_to_string(format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"))).expect("a file of the tests")
}

/// Runs the program with arguments as they are.
fn hfvdb(place: &Workplace, arguments: &[&OsStr]) -> Run {
    place.run(Command::new(env!("CARGO_BIN_EXE_hfvdb")).args(arguments))
}

#[test]
fn lengths_beyond_reason() {
    for (text, parts) in [
        ("box = 1e308", &["bad.toml:3:7", "from -1e15 to 1e15"][..]),
        ("sphere = 1\nmove = [1e308, 0, 0]", &["bad.toml:4:9", "from -1e15 to 1e15"]),
        ("sphere = 1\noffset = 1e300", &["bad.toml:4:10", "from -1e15 to 1e15"]),
        ("sphere = 1\nbounds = [[-1e308, -1, -1], [1, 1, 1]]", &["bad.toml:4:10", "must be a box"]),
        ("sphere = 1e-308", &["bad.toml:3:10", "at least 1e-15"]),
        ("sphere = \"1e30*(1 + t)\"", &["bad.toml:3:11", "1e30", "from -1e15 to 1e15"]),
        ("sphere = { 1 = 1, 1e300 = 2 }", &["bad.toml:3:19", "1e300", "not a frame"]),
        ("half_space = [1e-200, 0, 0]\nbounds = 1", &["bad.toml:3", "a length other than 0"]),
        ("formula = \"1e308 - x^2\"\nbounds = 1", &["bad.toml:3:12", "too large"]),
        ("sphere = 1e15\nscale = 1e15", &["bad.toml", "farther than can be computed"]),
        ("sphere = 1\nmove = [1e14, 0, 0]", &["bad.toml", "voxels of", "nearer to the origin"]),
    ] {
        let place = Workplace::new();
        place.write("bad.toml", format!("hfvdb = 1\n[shape.a]\n{text}\n"));
        in_time(text, || place.hfvdb("check bad.toml")).fails(1, parts);
        in_time(text, || place.hfvdb("bake bad.toml -o out.vdb --resolution 16")).fails(1, parts);
        assert_eq!(place.names("."), ["bad.toml"]);
    }
    let place = Workplace::new();
    for option in ["--voxel-size 1e308", "--voxel-size 1e16"] {
        place.hfvdb(&format!("check sphere {option}")).fails(2, &["1e15"]);
    }
    place.hfvdb("check sphere --voxel-size 1e-308").fails(1, &["sphere.toml", "too small for OpenVDB"]);
}

#[test]
fn nesting_has_an_end() {
    let place = Workplace::new();
    let deep = |open: &str, close: &str| format!("{}1{}", open.repeat(8000), close.repeat(8000));
    for (name, text) in [
        ("list.json", format!("{{\"a\": {}}}", deep("[", "]"))),
        ("table.json", deep("{\"a\":", "}")),
        ("open.json", "[".repeat(100_000)),
        ("list.toml", format!("a = {}", deep("[", "]"))),
        ("table.toml", format!("a = {}", deep("{a = ", "}"))),
        ("head.toml", format!("[{}a]\nb = 1", "a.".repeat(8000))),
        ("formula.toml", format!("[shape.a]\nsphere = \"{}\"", deep("(", ")"))),
    ] {
        place.write(name, text);
        in_time(name, || place.hfvdb(&format!("check {name}"))).fails(1, &[name, "nest"]);
    }
    // Brackets in a text are none.
    place.write("text.json", format!("{{\"param\": {{\"p\": {{\"value\": 1, \"text\": \"{}\\\"{{\"}}}}, \"shape\": {{\"a\": {{\"sphere\": 1}}}}}}", "[".repeat(500)));
    place.hfvdb("check text.json").ok();
}

#[test]
fn many_keys_take_little_time() {
    let place = Workplace::new();
    let many = |count: usize, line: &dyn Fn(usize) -> String| (0..count).map(line).collect::<String>();
    let ball = "[shape.a]\nsphere = 1\n";
    for (name, text, code) in [
        ("parameters.toml", format!("{ball}[param]\n{}", many(200_000, &|i| format!("k{i} = 1\n"))), 0),
        ("unknown.toml", format!("{ball}{}", many(200_000, &|i| format!("k{i} = 1\n"))), 1),
        ("union.toml", format!("{ball}[shape.b]\nunion = [{}]\n", many(100_000, &|_| "\"a\",".into())), 0),
        ("nowhere.toml", format!("{ball}[shape.b]\nunion = [{}]\n", many(100_000, &|i| format!("\"n{i}\","))), 1),
        (
            "keys.json",
            format!(
                "{{\"shape\":{{\"a\":{{\"sphere\":1}}}},\"param\":{{{}\"last\":1}}}}",
                many(200_000, &|i| format!("\"k{i}\":1,"))
            ),
            0,
        ),
    ] {
        place.write(name, text);
        let run = in_time(name, || place.hfvdb(&format!("check {name}")));
        if code == 0 {
            run.ok();
        } else {
            run.fails(code, &[name, "more\n"]);
        }
    }
}

/// A scene of so many levels, each made of the one before twice.
fn doubled(levels: usize, line: &dyn Fn(usize) -> String) -> String {
    let mut text = "[shape.s0]\nsphere = 1\ncolor = [\"0.5 + x/4\", 0.2, 0.4]\nattribute.warmth = \"z\"\n".to_string();
    for level in 1..=levels {
        let _ = writeln!(text, "[shape.s{level}]\n{}", line(level));
    }
    text
}

#[test]
fn shapes_that_many_share_are_looked_at_once() {
    let place = Workplace::new();
    place.write("shared.toml", data("shared-shapes.toml"));
    in_time("the case", || place.hfvdb("check shared.toml")).ok();
    let twice = |level: usize| format!("[\"s{0}\", \"s{0}\"]", level - 1);
    let lines: [(&str, &dyn Fn(usize) -> String); 4] = [
        ("union", &|level| format!("union = {}\nmove = [0.01, 0, 0]", twice(level))),
        ("moving", &|level| format!("union = {}\nmove = [\"0.01*t\", 0, 0]", twice(level))),
        ("intersection", &|level| format!("intersection = {}\nscale = 0.99", twice(level))),
        ("colour", &|level| format!("sphere = 1\ncolor = {{ parts = {} }}", twice(level))),
    ];
    for (name, line) in lines {
        let text = format!(
            "frames = \"1-2\"\n{}[output]\nshape = \"s64\"\ngrids = [\"surface\", \"Cd\", \"warmth\"]\n",
            doubled(64, line)
        );
        place.write("shared.toml", text);
        in_time(name, || place.hfvdb("check shared.toml")).ok();
        in_time(name, || place.hfvdb("bake shared.toml -o out.####.vdb --frames 1 --resolution 24 --overwrite")).ok();
    }
    // What is really so many copies is refused, and so is a chain without end.
    place.write(
        "copies.toml",
        doubled(30, &|level| {
            format!("union = [\"s{0}\", {{ union = [\"s{0}\"], move = [{level}, 0, 0] }}]", level - 1)
        }),
    );
    in_time("copies", || place.hfvdb("check copies.toml")).fails(1, &["copies.toml", "more than 1000000 shapes"]);
    place.write("chain.toml", doubled(20_000, &|level| format!("union = [\"s{}\"]\nmove = [0.001, 0, 0]", level - 1)));
    in_time("chain", || place.hfvdb("check chain.toml")).fails(1, &["chain.toml", "`s200`", "200 levels deep"]);
    place.write(
        "chain.toml",
        doubled(199, &|level| format!("union = [\"s{}\"]\nmove = [0.001, \"0.001*t\", 0]", level - 1)),
    );
    in_time("chain", || place.hfvdb("bake chain.toml -o chain.vdb --resolution 16 --overwrite")).ok();
}

#[test]
fn what_is_no_file_is_refused() {
    let place = Workplace::new();
    let made = Command::new("mkfifo").args(["pipe.toml", "pipe.obj", "pipe.vdb"]).current_dir(place.root()).status();
    assert!(made.is_ok_and(|status| status.success()));
    std::os::unix::fs::symlink("/dev/zero", place.path("zero.toml")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", place.path("zero.vdb")).unwrap();
    place.write("mesh.toml", "[shape.a]\nmesh = \"pipe.obj\"\n");
    for (arguments, parts) in [
        ("check pipe.toml", &["pipe.toml", "a pipe"][..]),
        ("check zero.toml", &["zero.toml", "a device"]),
        ("check mesh.toml", &["pipe.obj", "a pipe"]),
        ("morph pipe.obj pipe.obj -o m.####.vdb", &["pipe.obj", "a pipe"]),
        ("info pipe.vdb", &["pipe.vdb", "a pipe"]),
        ("check pipe.vdb", &["pipe.vdb", "a pipe"]),
        ("preview pipe.vdb -o p.png", &["pipe.vdb", "a pipe"]),
        ("info zero.vdb", &["zero.vdb", "a device"]),
        ("info .", &[".", "directory"]),
    ] {
        in_time(arguments, || place.hfvdb(arguments)).fails(1, parts);
    }
    // A pipe where a frame should stand is one that exists.
    in_time("output", || place.hfvdb("bake sphere -o pipe.vdb --resolution 16")).fails(1, &["pipe.vdb", "--overwrite"]);
    fs::create_dir(place.path("folder.vdb")).unwrap();
    in_time("output", || place.hfvdb("bake sphere -o folder.vdb --resolution 16")).fails(1, &["folder.vdb"]);
    let run = in_time("output", || place.hfvdb("bake sphere -o folder.vdb --resolution 16 --overwrite"));
    run.fails(1, &["folder.vdb"]);
    place.nothing_is_left(".");
}

#[test]
fn a_report_is_never_only_a_count() {
    let place = Workplace::new();
    place.write("names.toml", data("many-names.toml"));
    place.hfvdb("check names.toml").fails(1, &["names.toml:154:11", "raduis"]);
    place.write("m.ply", data("long-line.ply"));
    place.write("mesh.toml", "hfvdb = 1\n[shape.m]\nmesh = \"m.ply\"\n");
    place.hfvdb("check mesh.toml").fails(1, &["m.ply", "ine 10", "mesh.toml:3:9"]);
    place.write("empty.toml", "hfvdb = 1\n");
    place.hfvdb("check empty.toml").fails(1, &["empty.toml", "the scene has no shape"]);
}

/// Debian's Python OpenVDB writes names that no person would give.
#[test]
fn nothing_of_a_file_is_obeyed_by_a_terminal() {
    let place = Workplace::new();
    let script = "import pyopenvdb as v; g = v.createLevelSetSphere(1.0, voxelSize=0.1); \
                  g.name = 'a\\x1b[31m\\u009b2J\\nb'; g['not\\x1bte'] = 'c\\x07d'; v.write('m.vdb', grids=[g])";
    place.run(Command::new("/usr/bin/python3").args(["-c", script])).ok();
    let whole = fs::read(place.path("m.vdb")).unwrap();
    let at = whole.windows(15).position(|part| part == b"UniformScaleMap").expect("its map");
    let mut other = whole.clone();
    other[at..at + 7].copy_from_slice(b"\x1b[31mxx");
    place.write("map.vdb", other);
    place.write("s\u{1b}[1m.toml", "[shape.\"b\\u001B[2J\"]\nsphere = 1\n\"c\\u009B\" = 1\n");
    let runs = [
        place.hfvdb("info m.vdb"),
        place.hfvdb("info m.vdb --json"),
        place.hfvdb("check m.vdb --for blender,houdini,unreal,usd"),
        place.hfvdb("check m.vdb --json --progress json"),
        place.hfvdb("info map.vdb"),
        place.hfvdb("check map.vdb"),
        place.hfvdb("check s\u{1b}[1m.toml"),
        place.hfvdb("check s\u{1b}[1m.toml --json"),
        place.hfvdb("check no\u{1b}[1m.toml"),
        place.hfvdb("info no\u{1b}[1m.vdb"),
        place.hfvdb("bake sphere -o no\u{1b}[1m/x/m.vdb"),
        place.hfvdb("bake sphere --frames \u{1b}[1m -o m.vdb"),
    ];
    for run in runs {
        let text = format!("{}{}", run.stdout, run.stderr);
        assert!(!text.is_empty() && !text.contains(|c: char| c.is_control() && c != '\n'), "{text:?}");
    }
}

#[test]
fn names_that_are_no_text_are_told() {
    let place = Workplace::new();
    let name = |end: &str| OsStr::from_bytes(&[b"n\xff", end.as_bytes()].concat()).to_owned();
    for arguments in [["check".into(), name(".toml")], ["info".into(), name(".vdb")], ["verify".into(), name("")]] {
        let run = hfvdb(&place, &arguments.each_ref().map(|argument: &std::ffi::OsString| argument.as_os_str()));
        assert!(run.code != 0 && run.stderr.contains("n\\xff"), "{arguments:?}: {}", run.stderr);
    }
    let out = name(".vdb");
    let run = hfvdb(&place, &["bake".as_ref(), "sphere".as_ref(), "-o".as_ref(), &out]);
    run.fails(2, &["n\\xff.vdb"]);
}

#[test]
fn a_root_of_many_tiles_is_read_in_time() {
    let place = Workplace::new();
    let script = "import pyopenvdb as v\ng = v.FloatGrid(3.0); g.name = 'surface'; g.gridClass = v.GridClass.LEVEL_SET\n\
                  for i in range(200000):\n    o = (i//3600*4096, i//60%60*4096, i%60*4096)\n    \
                  g.fill(o, tuple(c + 4095 for c in o), 1.0 + i%7/10, True)\nv.write('tiles.vdb', grids=[g])";
    place.run(Command::new("/usr/bin/python3").args(["-c", script])).ok();
    let run = in_time("info", || place.hfvdb("info tiles.vdb")).ok();
    assert!(run.stdout.contains("values [1.0] to [1.6]"), "{}", run.stdout);
    in_time("check", || place.hfvdb("check tiles.vdb"));
}

#[test]
fn shapes_in_place_where_a_shape_is_taken() {
    let place = Workplace::new();
    place.write("facet.toml", data("octree-in-place.toml"));
    place.hfvdb("check facet.toml").ok();
    place.write("whole.toml", "[shape.f]\nfacet = { sphere = 1 }\ncells = { octree = { sphere = 1 } }\n");
    place.hfvdb("bake whole.toml -o f.vdb --resolution 24").ok();
    let deeper = "[shape.u]\nunion = [{ facet = \"b\", cells = { octree = { sphere = 1 } } }]\n[shape.b]\nsphere = 1\n";
    place.write("deeper.toml", deeper);
    place.hfvdb("check deeper.toml").ok();
}

#[test]
fn the_largest_piece_of_a_morph_stays() {
    let place = Workplace::new();
    place.write("piece.toml", data("min-piece.toml"));
    place.hfvdb("bake piece.toml -o a.####.vdb --resolution 24").ok();
    assert_eq!(place.frames("."), ["a.0001.vdb", "a.0002.vdb"]);
    let page = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/scene.md")).unwrap();
    assert!(page.contains("are left out; the largest always stays"));
}

#[test]
fn quoted_paths_are_those_of_the_shell() {
    let place = Workplace::new();
    fs::create_dir(place.path("home")).unwrap();
    let bake = |output: &str| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_hfvdb"));
        program.args(["bake", "sphere", "--resolution", "16", "-o", output]).env("HOME", place.path("home"));
        place.run(program.env("SHOT", "home"))
    };
    bake("~/a.vdb").ok();
    bake("$SHOT/b.vdb").ok();
    bake("${HOME}/c.$F4.vdb").ok();
    bake("$NO_SUCH_VARIABLE/d.vdb").fails(2, &["$NO_SUCH_VARIABLE", "not set"]);
    assert_eq!(place.names("."), ["home"]);
    assert_eq!(place.frames("home"), ["a.vdb", "b.vdb", "c.0001.vdb"]);
}

#[test]
fn frame_tokens_are_taken_as_written_or_refused() {
    let place = Workplace::new();
    let bake = |output: &str| place.hfvdb(&format!("bake sphere --resolution 16 -o {output}"));
    bake("m.%4d.vdb").fails(2, &["%4d", "spaces", "write %04d"]);
    bake("m.%0100d.vdb").fails(2, &["%0100d", "20 digits"]);
    assert!(place.names(".").is_empty());
    let run = bake("m.####.VDB").ok();
    assert!(!run.stderr.contains("warning"), "{}", run.stderr);
}

/// Debian's Python OpenVDB makes what this program never writes.
#[test]
fn files_of_others_are_told_of_rightly() {
    let place = Workplace::new();
    let script = "import pyopenvdb as v\ng = v.FloatGrid(); g.fill((0,0,0), (3,3,3), float('nan'), True); g.name = 'n'\n\
                  v.write('nan.vdb', grids=[g]); g = v.createLevelSetSphere(1.0, voxelSize=0.1); g.name = ''\n\
                  v.write('one.vdb', grids=[g])";
    place.run(Command::new("/usr/bin/python3").args(["-c", script])).ok();
    let run = place.hfvdb("info nan.vdb").ok();
    assert!(run.stdout.contains("no value is a finite number, 64 not finite"), "{}", run.stdout);
    assert!(!run.stdout.contains("inf"), "{}", run.stdout);
    let run = place.hfvdb("check one.vdb");
    assert!(!run.stderr.contains("another grid has this name"), "{}", run.stderr);
    run.fails(1, &["one.vdb", "it has no name"]);
}

#[test]
fn metadata_says_which_axis_points_up() {
    let place = Workplace::new();
    place.write("up.toml", "up = \"y\"\n[shape.a]\nsphere = 1\n");
    place.hfvdb("bake up.toml -o up.vdb --resolution 16").ok();
    assert!(place.hfvdb("info up.vdb").ok().stdout.contains("hfvdb_up: y"));
}

/// Runs the program on a terminal of Python's.
#[test]
fn colours_only_where_they_are_wanted() {
    let place = Workplace::new();
    place.write("bad.toml", "[shape.a]\nsphere = -1\n");
    let script =
        format!("import pty, sys; sys.exit(pty.spawn(['{}', 'check', 'bad.toml']) >> 8)", env!("CARGO_BIN_EXE_hfvdb"));
    for (term, no_colour, coloured) in [("xterm", "", true), ("dumb", "", false), ("xterm", "1", false)] {
        let mut python = Command::new("/usr/bin/python3");
        python.args(["-c", &script]).env("TERM", term).env("NO_COLOR", no_colour).stdin(Stdio::null());
        let run = place.run(&mut python);
        assert!(run.stdout.contains("sphere"), "{}", run.stdout);
        assert_eq!(run.stdout.contains('\u{1b}'), coloured, "TERM={term} NO_COLOR={no_colour}: {:?}", run.stdout);
    }
    let bare = place.hfvdb("check bad.toml");
    assert!(!bare.stderr.contains('\u{1b}'));
}
