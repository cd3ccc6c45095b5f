//! Frames as a farm bakes them: records and manifests, resuming, chunks side by side, whatever is found in the folder.

mod support;

use std::fs::{self, File};
use std::os::unix::fs::MetadataExt;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use support::{BAKE, BALL, Workplace, json, manifest, workplace};

/// Starts the program in the workplace.
fn start(place: &Workplace, arguments: &str) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hfvdb"));
    command.args(arguments.split_whitespace()).current_dir(place.root());
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts")
}

fn end(child: Child) -> support::Run {
    support::Run::from(child.wait_with_output().expect("it ends"))
}

fn inodes(place: &Workplace) -> Vec<u64> {
    place.frames("out").iter().map(|name| fs::metadata(place.path("out").join(name)).unwrap().ino()).collect()
}

#[test]
fn resume_judges_by_content() {
    let place = workplace();
    place.hfvdb(&format!("{BAKE} --frames 1-8")).ok();
    let before = inodes(&place);
    // Missing, cut, replaced by a file as long, and one of unknown making.
    fs::remove_file(place.path("out/m.0002.vdb")).unwrap();
    let cut = fs::read(place.path("out/m.0003.vdb")).unwrap();
    fs::write(place.path("out/m.0003.vdb"), &cut[..cut.len() - 1]).unwrap();
    let long = fs::metadata(place.path("out/m.0004.vdb")).unwrap().len() as usize;
    fs::write(place.path("out/m.0004.vdb"), vec![0; long]).unwrap();
    fs::remove_file(place.path("out/.m.0005.hfvdb-record.json")).unwrap();
    fs::remove_file(place.path("out/m.manifest.json")).unwrap();
    let run = place.hfvdb(&format!("{BAKE} --frames 1-9 --resume --json")).ok();
    assert!(run.stderr.contains("resume: 4 of 9 frames are done; missing: 2,9; changed"), "{}", run.stderr);
    let document = json(&run.stdout);
    let states: Vec<_> =
        document["frames"].as_array().unwrap().iter().map(|frame| frame["state"].as_str().unwrap()).collect();
    assert_eq!(states, ["kept", "written", "written", "written", "written", "kept", "kept", "kept", "written"]);
    let after = inodes(&place);
    for kept in [0, 5, 6, 7] {
        assert_eq!(before[kept], after[kept], "frame {} was baked again", kept + 1);
    }
    place.hfvdb("verify out").ok();

    // Other options: what was asked for is baked again, and the rest is told by verify.
    let finer = BAKE.replace("16", "20");
    place.hfvdb(&format!("{finer} --frames 1-2")).fails(1, &["m.0001.vdb exists", "--resume"]);
    place.hfvdb(&format!("{finer} --frames 12")).fails(1, &["resolution 16 there, resolution 20 here", "--overwrite"]);
    let run = place.hfvdb(&format!("{finer} --frames 1-2 --resume")).ok();
    assert!(run.stderr.contains("0 of 2 frames are done; baked otherwise (sampling resolution 16"), "{}", run.stderr);
    place.hfvdb("verify out").fails(1, &["frames 1-2 (", "of another bake than most", "resolution 20 there"]);
    place.hfvdb(&format!("{finer} --frames 1-9 --resume")).ok();
    place.hfvdb("verify out").ok();
    place.hfvdb(&format!("{BAKE} --resume --overwrite")).fails(2, &["--overwrite", "--resume"]);
}

#[test]
fn another_scene_is_refused_before_any_work() {
    let place = workplace();
    let hash = |scene: &str| {
        let name = scene.replace(".toml", "");
        place.hfvdb(&format!("bake {scene} --resolution 16 --frames 1 -o {name}.vdb")).ok();
        let info = json(&place.hfvdb(&format!("info {name}.vdb --json")).ok().stdout);
        info["files"][0]["metadata"]["hfvdb_scene"].as_str().expect("a hash").to_owned()
    };
    let (ball, egg) = (hash("ball.toml"), hash("egg.toml"));
    place.hfvdb(&format!("{BAKE} --frames 1-4")).ok();
    let (names, whole) = (place.names("out"), fs::read(place.path("out/m.manifest.json")).unwrap());
    let other = BAKE.replace("ball", "egg");
    for how in ["--frames 5-8", "--frames 1-4", "--frames 1-8 --resume", "--frames 5-8 --dry-run"] {
        place.hfvdb(&format!("{other} {how}")).fails(1, &["another scene", &ball, &egg, "--overwrite"]);
        assert_eq!(
            (place.names("out"), fs::read(place.path("out/m.manifest.json")).unwrap()),
            (names.clone(), whole.clone())
        );
    }
    // The manifest is lost: single frames of the other scene still stand against it, and --resume replaces them.
    fs::remove_file(place.path("out/m.manifest.json")).unwrap();
    place.hfvdb(&format!("{other} --frames 5-8")).fails(1, &[&ball, &egg]);
    let run = place.hfvdb(&format!("{other} --frames 1-2 --resume")).ok();
    assert!(run.stderr.contains("baked otherwise (scene"), "{}", run.stderr);
    place.hfvdb(&format!("{other} --frames 3 --overwrite")).ok();
    place.hfvdb("verify out").fails(1, &["m.0004.vdb: of another bake than most: scene"]);
    place.hfvdb(&format!("{other} --frames 1-4 --resume")).ok();
    place.hfvdb("verify out").ok();

    // Frames that somebody has deleted stand against nothing.
    for name in place.frames("out") {
        fs::remove_file(place.path("out").join(name)).unwrap();
    }
    place.hfvdb(&format!("{BAKE} --frames 1-2")).ok();
    place.hfvdb("verify out").ok();

    // A still of the same name in the same folder.
    place.hfvdb("bake ball.toml --resolution 16 --frames 1 -o out/m.vdb").fails(1, &["m.manifest.json", "m.####.vdb"]);
}

#[test]
fn a_dry_run_writes_nothing_and_tells_what_would_come() {
    let place = workplace();
    let before = place.names(".");
    let run = place.hfvdb(&format!("{BAKE} --dry-run --json --frames 1-24x4")).ok();
    assert_eq!(place.names("."), before);
    let told = json(&run.stdout);
    assert_eq!(told["frames"].as_array().map(Vec::len), Some(6));
    assert_eq!(told["frames"][1]["path"], "out/m.0005.vdb");
    assert!(told["frames"].as_array().unwrap().iter().all(|frame| frame["fate"] == "new"));
    let probe = told["probe"]["frame"].as_i64().unwrap();
    let baked = json(&place.hfvdb(&format!("{BAKE} --frames {probe} --json")).ok().stdout);
    assert_eq!(told["estimate"]["active_voxels"].as_f64(), baked["frames"][0]["active_voxels"].as_f64());
    assert_eq!(told["estimate"]["file_bytes"], baked["frames"][0]["bytes"]);

    place.hfvdb(&format!("{BAKE} --dry-run")).fails(1, &["exists", "--resume"]);
    let run = place.hfvdb(&format!("{BAKE} --dry-run --resume")).ok();
    assert!(
        run.stdout.contains("23 frames to bake, 1 to keep") && run.stdout.contains("baked in memory"),
        "{}",
        run.stdout
    );
    assert!(run.stdout.contains(&format!("out/m.{probe:04}.vdb kept\n")), "{}", run.stdout);
    place.hfvdb("bake ball.toml --dry-run -o no/such/m.####.vdb").fails(1, &["does not exist"]);

    // Where a frame is large, a coarser one stands in for it, and says so.
    let run = place
        .hfvdb("bake ball.toml --resolution 3000 -o big/m.####.vdb --frames 24 --dry-run --json --max-memory 64G")
        .ok();
    let told = json(&run.stdout);
    let coarser = told["probe"]["coarser"].as_f64().unwrap();
    assert!(coarser > 1.5, "{told}");
    // A ball's band: the area times the band's width, in voxels.
    let expected = std::f64::consts::PI * 3000.0 * 3000.0 * 6.0;
    let voxels = told["estimate"]["active_voxels"].as_f64().unwrap();
    assert!((voxels / expected - 1.0).abs() < 0.02, "{voxels}, expected {expected}");
}

#[test]
fn nobody_reading_stderr_stops_no_bake() {
    let place = workplace();
    for (arguments, code) in [(format!("{BAKE} --frames 30"), 0), ("bake no.toml -o out/n.vdb".into(), 1)] {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let mut command = Command::new(env!("CARGO_BIN_EXE_hfvdb"));
        command.args(arguments.split_whitespace()).current_dir(place.root()).stdout(Stdio::null()).stderr(writer);
        assert_eq!(command.status().expect("the program starts").code(), Some(code), "{arguments}");
    }
    assert_eq!(place.frames("out"), ["m.0030.vdb"]);
}

#[test]
fn the_log_of_events_is_json_line_by_line() {
    let place = workplace();
    place.hfvdb(&format!("{BAKE} --frames 3")).ok();
    let run = place.hfvdb(&format!("{BAKE} --frames 2-4,40 --resume --progress json")).ok();
    let events: Vec<Value> = run.stderr.lines().map(json).collect();
    let names: Vec<_> = events.iter().map(|event| event["event"].as_str().expect("its name")).collect();
    for (name, count) in [("start", 1), ("frame-started", 3), ("frame-written", 3), ("done", 1), ("warning", 1)] {
        assert_eq!(names.iter().filter(|event| **event == name).count(), count, "{name} in {names:?}");
    }
    let done = events.last().unwrap();
    assert_eq!((done["written"].as_u64(), done["kept"].as_u64()), (Some(3), Some(1)));
    let written = events.iter().find(|event| event["event"] == "frame-written").unwrap();
    assert_eq!(written["record"]["frame"], 2);
    assert!(events.iter().all(|event| event["seconds"].is_f64()));

    let run = place.hfvdb(&format!("{BAKE} --frames 3 --progress json"));
    let last = json(run.stderr.lines().last().unwrap());
    assert_eq!((run.code, &last["event"], last["exit_code"].as_i64()), (1, &Value::from("failed"), Some(1)));
}

#[test]
fn frames_that_fail_by_themselves_do_not_stop_the_others() {
    let place = workplace();
    // A colour that is no number from frame 4 on.
    place.write(
        "dark.toml",
        BALL.replace("1-24", "1-6").replace("24 = 1", "6 = 1").replace("\"t\"", "\"sqrt(0.5 - t)\""),
    );
    let bake = "bake dark.toml --resolution 16";
    let run = place.hfvdb(&format!("{bake} -o out/m.####.vdb --json"));
    run.fails(1, &["dark.toml:5:9", "3 of 6 frames failed: 4-6", "3 of 6 frames are done", "--resume"]);
    assert_eq!(place.frames("out"), ["m.0001.vdb", "m.0002.vdb", "m.0003.vdb"]);
    let document = json(&run.stdout);
    assert_eq!(document["failed"].as_array().map(Vec::len), Some(3));
    assert_eq!(document["error"]["exit_code"], 1);
    place.nothing_is_left("out");
    place.hfvdb("verify out").fails(1, &["m.0004.vdb", "missing: it was never finished"]);
    place.hfvdb(&format!("{bake} -o out/m.####.vdb --resume")).fails(1, &["3 of 6 frames failed: 4-6"]);
    // Nothing came of it, and nothing stays.
    place.hfvdb(&format!("{bake} -o new/m.####.vdb --frames 4-6")).fails(1, &["3 of 3 frames failed"]);
    assert!(!place.path("new").exists());
    // Whatever failed, a sequence that was there stays as it was.
    let before = (place.names("out"), fs::read(place.path("out/m.manifest.json")).unwrap());
    place.write("wrong.toml", BALL.replace("\"t\"", "\"sqrt(-1 - t)\""));
    place.hfvdb("bake wrong.toml --resolution 16 -o out/m.####.vdb --frames 1-2 --overwrite").fails(1, &["2 of 2"]);
    assert_eq!((place.names("out"), fs::read(place.path("out/m.manifest.json")).unwrap()), before);
}

#[test]
fn chunks_of_one_scene_work_side_by_side() {
    let place = workplace();
    fs::create_dir(place.path("out")).unwrap();
    let chunks = ["1-8", "9-16", "17-24"].map(|frames| start(&place, &format!("{BAKE} --frames {frames} --threads 1")));
    for chunk in chunks {
        end(chunk).ok();
    }
    assert_eq!(manifest(&place)["asked"], "1-24");
    assert_eq!(manifest(&place)["frames"].as_array().map(Vec::len), Some(24));
    place.hfvdb("verify out").ok();
    place.nothing_is_left("out");

    // Two that were given the same frames share them.
    fs::remove_dir_all(place.path("out")).unwrap();
    fs::create_dir(place.path("out")).unwrap();
    let twins = [0, 1].map(|_| start(&place, &format!("{BAKE} --resume --json --threads 1")));
    let written: usize = twins
        .map(|twin| {
            let document = json(&end(twin).ok().stdout);
            let frames = document["frames"].as_array().unwrap().clone();
            assert_eq!(frames.len(), 24);
            frames.iter().filter(|frame| frame["state"] == "written").count()
        })
        .iter()
        .sum();
    assert_eq!(written, 24, "a frame was baked twice");
    place.hfvdb("verify out").ok();
    place.nothing_is_left("out");
}

#[test]
fn of_two_scenes_at_once_one_is_refused() {
    let place = workplace();
    fs::create_dir(place.path("out")).unwrap();
    for _ in 0..10 {
        let both = [BAKE.into(), BAKE.replace("ball", "egg")].map(|bake| start(&place, &format!("{bake} --threads 1")));
        let [one, other] = both.map(end);
        let (done, refused) = if one.code == 0 { (one, other) } else { (other, one) };
        done.ok();
        refused.fails(1, &["another scene"]);
        place.hfvdb("verify out").ok();
        for name in place.names("out") {
            fs::remove_file(place.path("out").join(name)).unwrap();
        }
    }
}

#[test]
fn locks_of_living_processes_hold_and_those_of_dead_ones_do_not() {
    let place = workplace();
    place.hfvdb(&format!("{BAKE} --frames 1")).ok();
    // Left behind by a process that was killed.
    for name in [
        ".m.0002.hfvdb-lock",
        ".m.1-2.hfvdb-run-lock",
        ".m.hfvdb-manifest-lock",
        ".m.0002.vdb.a1b2c3.hfvdb-tmp",
        "..m.0002.hfvdb-record.json.a1b2c3.hfvdb-tmp",
        ".m.manifest.json.a1b2c3.hfvdb-tmp",
        ".n.0002.vdb.a1b2c3.hfvdb-tmp",
    ] {
        place.write(&format!("out/{name}"), "");
    }
    place.hfvdb(&format!("{BAKE} --frames 2")).ok();
    assert!(place.path("out/.n.0002.vdb.a1b2c3.hfvdb-tmp").exists(), "of another sequence");
    fs::remove_file(place.path("out/.n.0002.vdb.a1b2c3.hfvdb-tmp")).unwrap();
    place.nothing_is_left("out");

    // A process at work, played by this test.
    let hold = |name: &str| {
        let lock = File::create(place.path("out").join(name)).unwrap();
        lock.lock().unwrap();
        lock
    };
    let run_lock = hold(".m.7-7.hfvdb-run-lock");
    let other = BAKE.replace("ball", "egg");
    place.hfvdb(&format!("{other} --overwrite")).fails(1, &["another process bakes them now"]);
    let frame_lock = hold(".m.0003.hfvdb-lock");
    let waiting = start(&place, &format!("{BAKE} --frames 3-4"));
    let begin = Instant::now();
    while !place.path("out/.m.0004.hfvdb-record.json").exists() {
        assert!(begin.elapsed() < Duration::from_secs(60), "frame 4 never came");
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(!place.path("out/m.0003.vdb").exists());
    drop(frame_lock);
    end(waiting).ok();
    drop(run_lock);
    place.hfvdb(&format!("{BAKE} --frames 1-4 --resume")).ok();
    place.hfvdb("verify out").ok();
    place.nothing_is_left("out");
}

#[test]
fn a_folder_that_goes_away_ends_the_bake_with_a_message() {
    let place = workplace();
    let child = start(&place, "bake ball.toml --resolution 64 --frames 1-400 -o out/m.####.vdb");
    let begin = Instant::now();
    while !place.path("out/m.0002.vdb").exists() {
        assert!(begin.elapsed() < Duration::from_secs(60), "frame 2 never came");
        std::thread::sleep(Duration::from_millis(5));
    }
    fs::rename(place.path("out"), place.path("elsewhere")).unwrap();
    let run = end(child);
    run.fails(1, &["error: out", "cannot", "of 400 frames are done"]);
    assert!(!place.path("out").exists());
    for name in place.frames("elsewhere") {
        place.hfvdb(&format!("info elsewhere/{name}")).ok();
    }
}

#[test]
fn four_hundred_finished_frames_are_judged_in_seconds() {
    let place = workplace();
    place.write("long.toml", BALL.replace("1-24", "1-400").replace("24 = 1", "400 = 1"));
    let bake = "bake long.toml --resolution 16 -o out/m.####.vdb";
    place.hfvdb(bake).ok();
    let before = inodes(&place);
    let begin = Instant::now();
    let run = place.hfvdb(&format!("{bake} --resume")).ok();
    assert!(begin.elapsed() < Duration::from_secs(5), "{:?}", begin.elapsed());
    assert!(run.stderr.contains("400 of 400 frames are done"), "{}", run.stderr);
    assert_eq!(inodes(&place), before);
}
