//! Bad input gets the right exit code, one message with file, place and a way out, and leaves nothing behind.

mod support;

use std::fs;
use std::process::Command;
use std::time::{Duration, Instant};

use support::Workplace;

/// Bakes a scene's text and expects a failure that writes nothing.
fn scene_fails(text: &str, code: i32, parts: &[&str]) {
    let place = Workplace::new();
    place.write("bad.toml", text);
    let run = place.hfvdb("bake bad.toml -o out.vdb --resolution 32");
    run.fails(code, parts);
    assert_eq!(place.names("."), ["bad.toml"], "something was left behind");
}

#[test]
fn syntax_error() {
    scene_fails("[shape.a]\nsphere = = 1\n", 1, &["bad.toml:2:10"]);
}

#[test]
fn unknown_key_names_the_nearest() {
    scene_fails("[shape.a]\nsphere = 1\ncolr = \"red\"\n", 1, &["bad.toml:3:1", "colr", "color"]);
}

#[test]
fn name_that_points_nowhere() {
    scene_fails(
        "[shape.ball]\nsphere = 1\n[shape.u]\nunion = [\"ball\", \"bal\"]\n",
        1,
        &["bad.toml:4", "bal", "ball"],
    );
}

#[test]
fn cycle_shows_its_way() {
    scene_fails("[shape.a]\nunion = [\"b\"]\n[shape.b]\nunion = [\"a\"]\n", 1, &["bad.toml", "a", "b"]);
}

#[test]
fn several_errors_come_together() {
    scene_fails(
        "[shape.a]\nsphere = -1\ncolr = 3\n[shape.b]\nbox = \"wide\"\n",
        1,
        &["bad.toml:2", "bad.toml:3", "bad.toml:5"],
    );
}

#[test]
fn nan_from_a_formula() {
    scene_fails(
        "[shape.a]\nformula = \"sqrt(x) - 0.2 - y^2 - z^2\"\nbounds = [[-1,-1,-1],[1,1,1]]\n",
        1,
        &["bad.toml", "not a number"],
    );
}

#[test]
fn unbounded_shape() {
    scene_fails("[shape.a]\nhalf_space = [0, 0, 1]\n", 1, &["bad.toml", "bounds"]);
}

#[test]
fn empty_result() {
    scene_fails(
        "[shape.a]\nintersection = [\"b\", \"c\"]\n[shape.b]\nsphere = 1\n[shape.c]\nsphere = 1\nmove = [3, 0, 0]\n",
        1,
        &["bad.toml:1:8", "nothing is inside `a`"],
    );
}

#[test]
fn missing_scene() {
    let place = Workplace::new();
    place.hfvdb("bake nowhere.toml -o out.vdb").fails(1, &["nowhere.toml"]);
    place.hfvdb("bake cubsm -o out.vdb").fails(1, &["cubsm", "cubism"]);
}

#[test]
fn meshes() {
    let place = Workplace::new();
    let cube = include_str!("../scenes/cube.obj");
    let good = place.write("good.obj", cube);
    assert!(good.exists());
    place.write("empty.obj", "");
    place.write("cut.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n");
    place.write("nan.obj", cube.replacen("v ", "v nan nan nan\nv ", 1));
    // All faces but the last: an open box.
    let last_face = cube.rfind("\nf ").expect("a face");
    place.write("open.obj", &cube[..last_face]);
    for (mesh, parts) in [
        ("missing.obj", &["missing.obj"][..]),
        ("empty.obj", &["empty.obj"]),
        ("cut.ply", &["cut.ply"]),
        ("nan.obj", &["nan.obj"]),
        ("open.obj", &["open.obj", "open"]),
        ("good.stl", &["good.stl"]),
    ] {
        let run = place.hfvdb(&format!("morph good.obj {mesh} -o m.####.vdb --resolution 24"));
        run.fails(1, parts);
        assert!(!place.names(".").iter().any(|name| name.ends_with("vdb") || name.contains("tmp")), "{mesh}");
    }
}

#[test]
fn voxel_sizes() {
    let place = Workplace::new();
    for (size, code) in [("0", 2), ("-1", 2), ("nan", 2), ("inf", 2), ("x", 2), ("1e-9", 1)] {
        place.hfvdb(&format!("bake sphere -o out.vdb --voxel-size {size}")).fails(code, &["voxel"]);
    }
    place.hfvdb("bake heart -o out.vdb --resolution 1000000").fails(1, &["too small for OpenVDB", "unit"]);
    for absurd in ["heart --voxel-size 0.00002", "heart --resolution 130000", "cubism --voxel-size 0.00002"] {
        place.hfvdb(&format!("bake {absurd} -o out.####.vdb")).fails(3, &["--max-memory", "TiB"]);
    }
    place.hfvdb("bake heart -o out.vdb --resolution 256 --max-memory 5M").fails(3, &["--max-memory", "MiB"]);
    assert!(place.names(".").is_empty());
}

#[test]
fn output_places() {
    let place = Workplace::new();
    place.hfvdb("bake sphere --resolution 16 -o no/such/out.vdb").fails(1, &["no", "does not exist"]);
    place.hfvdb("bake sphere --resolution 16 -o out.exr").fails(2, &["out.exr", ".vdb"]);
    place.hfvdb("bake cube-to-heart --resolution 16 -o out.vdb").fails(2, &["####", "$F4"]);
    place.hfvdb("bake sphere --resolution 16 -o /proc/out.vdb").fails(1, &["/proc"]);
    assert!(place.names(".").is_empty());

    place.write("there.vdb", "mine");
    place.hfvdb("bake sphere --resolution 16 -o there.vdb").fails(1, &["there.vdb", "--overwrite"]);
    assert_eq!(fs::read(place.path("there.vdb")).unwrap(), b"mine");
    place.hfvdb("bake sphere --resolution 16 -o there.vdb --overwrite").ok();
    // The last folder is made, not more.
    place.hfvdb("bake sphere --resolution 16 -o new/out.vdb").ok();
    assert_eq!(place.names("new"), [".out.hfvdb-record.json", "out.manifest.json", "out.vdb"]);
}

/// A disk that takes no more bytes: a limit on the size of files stands in for it, which needs no rights.
#[test]
fn full_disk() {
    let place = Workplace::new();
    let program = env!("CARGO_BIN_EXE_hfvdb");
    for blocks in [1, 20, 60] {
        for trap in ["trap '' XFSZ; ", ""] {
            let script = format!("{trap}ulimit -f {blocks}; exec {program} bake sphere --resolution 96 -o out.vdb");
            let run = place.run(Command::new("bash").args(["-c", &script]));
            run.fails(1, &["out.", "too large"]);
            assert!(place.names(".").is_empty(), "{blocks}: {:?}", place.names("."));
        }
    }
}

#[test]
fn damaged_files() {
    let place = Workplace::new();
    place.hfvdb("bake heart --resolution 32 -o good.vdb").ok();
    let good = fs::read(place.path("good.vdb")).unwrap();
    for (name, bytes) in [
        ("cut.vdb", &good[..good.len() * 2 / 3]),
        ("short.vdb", &good[..10]),
        ("text.vdb", b"this is no VDB file at all"),
        ("empty.vdb", b""),
    ] {
        place.write(name, bytes);
        place.hfvdb(&format!("info {name}")).fails(1, &[name]);
        place.hfvdb(&format!("preview {name} -o p.png")).fails(1, &[name]);
        assert!(!place.path("p.png").exists());
    }
    place.hfvdb("info missing.vdb").fails(1, &["missing.vdb"]);
}

#[test]
fn files_are_checked_for_programs() {
    let place = Workplace::new();
    place.hfvdb("bake heart -o m_0001_v2.vdb --resolution 32").ok();
    let run = place.hfvdb("check m_0001_v2.vdb --for blender,houdini,usd --json").ok();
    assert!(run.stderr.contains("for blender: its frame's number is read as 2, not 0001"), "{}", run.stderr);
    let document: serde_json::Value = serde_json::from_str(&run.stdout).expect("one document");
    // The still's own number is 1.
    let clients: Vec<_> = document["findings"].as_array().expect("a list").iter().map(|one| &one["client"]).collect();
    assert_eq!(clients, [&serde_json::Value::Null, &serde_json::Value::from("blender")]);
    place.hfvdb("check m_0001_v2.vdb --for maya").fails(2, &["maya", "blender, houdini, karma, arnold"]);
    place.hfvdb("check heart --for blender").fails(2, &["--for", ".vdb"]);
}

#[test]
fn interrupted() {
    for (signal, code) in [("INT", 130), ("TERM", 143), ("HUP", 129), ("XCPU", 152)] {
        let place = Workplace::new();
        let mut child = Command::new(env!("CARGO_BIN_EXE_hfvdb"))
            .args("bake cubism --resolution 160 -o out/m.####.vdb".split(' '))
            .current_dir(place.root())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(1500));
        let start = Instant::now();
        let sent = Command::new("kill").args(["-s", signal, &child.id().to_string()]).status().unwrap();
        assert!(sent.success());
        let status = child.wait().unwrap();
        assert!(start.elapsed() < Duration::from_secs(2), "{:?}", start.elapsed());
        assert_eq!(status.code(), Some(code));
        if place.path("out").exists() {
            place.nothing_is_left("out");
            for name in place.frames("out") {
                place.hfvdb(&format!("info out/{name}")).ok();
            }
        }
    }
}

/// Files by folder, by pattern and by name: one summary, what is the same of many said once, and exit code 1 where any is
/// not sound.
#[test]
fn many_files_are_checked_at_once() {
    let place = support::workplace();
    place.hfvdb("bake ball.toml --resolution 16 -o out/m.####.vdb --frames 1-4 --half-width 2").ok();
    for what in ["out", "out/", "out/m.####.vdb", "out/m.0001.vdb out/m.0002.vdb out/m.0003.vdb out/m.0004.vdb out"] {
        let run = place.hfvdb(&format!("check {what}")).ok();
        assert_eq!(run.stdout, "4 files: 4 sound, 0 not; 0 errors, 4 warnings\n", "{what}");
        assert!(
            run.stderr.starts_with("warning: out/m.0001.vdb and 3 more: grid 'surface': its band"),
            "{}",
            run.stderr
        );
    }
    let whole = fs::read(place.path("out/m.0003.vdb")).unwrap();
    place.write("out/m.0003.vdb", &whole[..whole.len() / 2]);
    place.hfvdb("check out").fails(1, &["error: out/m.0003.vdb: ", "1 of 4 files are not sound"]);
    let run = place.hfvdb("check out/m.%04d.vdb --json");
    run.fails(1, &[]);
    let told = support::json(&run.stdout);
    assert_eq!((&told["unsound"], told["files"].as_array().map(Vec::len)), (&serde_json::json!(1), Some(4)));
    assert_eq!(told["files"][2]["findings"][0]["severity"], "error");
    place.hfvdb("check out ball.toml").fails(2, &["one scene, or any number of .vdb files"]);
    fs::create_dir(place.path("bare")).unwrap();
    place.hfvdb("check bare").fails(1, &["bare: there is no .vdb file in this folder"]);
    place.hfvdb("check bare/m.####.vdb").fails(1, &["no frame with such a name"]);
    // A folder may be called as a built-in scene is.
    fs::create_dir(place.path("heart")).unwrap();
    place.hfvdb("check heart --resolution 16").ok();
    place.hfvdb("check heart/").fails(1, &["heart/: there is no .vdb file"]);
}

#[test]
fn files_of_any_maker_are_checked() {
    let place = Workplace::new();
    place.hfvdb("bake sphere -o ball.vdb --resolution 24").ok();
    let run = place.hfvdb("check ball.vdb").ok();
    assert_eq!(run.stdout, "ball.vdb: grids surface, Cd; 0 errors, 0 warnings\n");
    let whole = fs::read(place.path("ball.vdb")).expect("it was baked");
    place.write("cut.vdb", &whole[..whole.len() / 2]);
    place.write("text.vdb", "no volume at all");
    place.hfvdb("check cut.vdb").fails(1, &["cut.vdb", "damaged at byte"]);
    place.hfvdb("check text.vdb").fails(1, &["text.vdb", "it is no OpenVDB file"]);
    place.hfvdb("check nowhere.vdb").fails(1, &["nowhere.vdb"]);
}

/// Debian's Python OpenVDB makes what this program never writes.
#[test]
fn a_file_that_is_not_sound_gives_one_document_and_exit_code_1() {
    let place = Workplace::new();
    for (change, problem) in [
        ("g.mapAll(lambda x: -x); g.background = -0.3", "turn its signs round"),
        ("g.getAccessor().setValueOn((10, 0, 0), float('nan'))", "1 values are not finite numbers"),
        ("g.getAccessor().setValueOn((10, 0, 0), 5.0)", "1 active values lie beyond its background"),
        ("g.transform = v.createLinearTransform([[.1,0,0,0],[0,.1,0,0],[0,0,.2,0],[0,0,0,1]])", "are no cubes"),
    ] {
        let script = format!(
            "import pyopenvdb as v; g = v.createLevelSetSphere(1.0, voxelSize=0.1, halfWidth=3.0); {change}; \
             g.name = 'surface'; v.write('bad.vdb', grids=[g])"
        );
        place.run(Command::new("/usr/bin/python3").args(["-c", &script])).ok();
        let run = place.hfvdb("check bad.vdb --json");
        let document: serde_json::Value = serde_json::from_str(&run.stdout).expect("one document");
        assert_eq!(document["findings"][0]["severity"], "error");
        run.fails(1, &["bad.vdb", problem]);
    }
}

#[test]
fn a_failed_bake_leaves_no_folder_that_it_made() {
    let place = Workplace::new();
    let text = "[shape.a]\nsphere = 1\ncolor = [0.5, \"sqrt(x)\", 0]\n";
    place.write("bad.toml", text);
    place.hfvdb("bake bad.toml -o out/a.vdb --resolution 24").fails(1, &["bad.toml:3:9", "frame 1", "NaN"]);
    assert_eq!(place.names("."), ["bad.toml"]);
    fs::create_dir(place.path("mine")).expect("a folder");
    place.hfvdb("bake bad.toml -o mine/a.vdb --resolution 24").fails(1, &["bad.toml:3:9"]);
    assert_eq!(place.names("."), ["bad.toml", "mine"]);
}
