//! Polygons of several frames in one USD file: written whole, kept, gone on with and refused as frames are.

mod support;

use std::fs;

use hfvdb::disk::FileLock;
use support::{Workplace, json, workplace};

const BAKE: &str = "bake ball.toml --resolution 16 -o out/ball.usda";

fn text(place: &Workplace, name: &str) -> String {
    fs::read_to_string(place.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The frames of each attribute's samples.
fn samples(text: &str) -> Vec<(String, Vec<i64>)> {
    let mut all: Vec<(String, Vec<i64>)> = Vec::new();
    for line in text.lines().map(str::trim) {
        if let Some(name) = line.strip_suffix(".timeSamples = {") {
            all.push((name.to_owned(), Vec::new()));
        } else if let (Some((frame, _)), Some((_, frames))) = (line.split_once(": ["), all.last_mut()) {
            frames.push(frame.parse().expect("a frame"));
        }
    }
    all
}

#[test]
fn one_file_holds_all_frames() {
    let place = workplace();
    let written = place.hfvdb(&format!("{BAKE} --frames 2-4,9")).ok();
    assert_eq!(written.stdout, "out/ball.usda\n");
    let whole = text(&place, "out/ball.usda");
    assert!(
        whole.contains("startTimeCode = 2\n    endTimeCode = 9\n") && whole.contains("upAxis = \"Z\""),
        "{whole:.900}"
    );
    let names: Vec<String> = samples(&whole).iter().map(|(name, _)| name.clone()).collect();
    let wanted = [
        "float3[] extent",
        "int[] faceVertexCounts",
        "int[] faceVertexIndices",
        "point3f[] points",
        "color3f[] primvars:displayColor",
    ];
    assert_eq!(names, wanted);
    assert!(samples(&whole).iter().all(|(_, frames)| frames == &[2, 3, 4, 9]));
    // What stood beside it on the way is gone.
    assert_eq!(place.names("out"), [".ball.usda.hfvdb-record.json", "ball.usda", "ball.usda.manifest.json"]);
    let record = json(&text(&place, "out/.ball.usda.hfvdb-record.json"));
    assert_eq!(record["record"]["frames"].as_array().map(Vec::len), Some(4));
    assert_eq!(json(&text(&place, "out/ball.usda.manifest.json"))["asked"], "2-4,9");
    assert!(place.hfvdb("verify out").ok().stderr.is_empty());

    // The same each time, and of frames of their own.
    place.hfvdb("bake ball.toml --resolution 16 -o out/again.usda --frames 2-4,9 --threads 1").ok();
    assert!(text(&place, "out/again.usda") == whole.replace("\"ball\"", "\"again\""));
    place.hfvdb("bake ball.toml --resolution 16 -o frames/####.usda --frames 2-4").ok();
    let one = text(&place, "frames/0003.usda");
    assert!(samples(&one).iter().all(|(_, frames)| frames == &[3]));
    assert!(whole.contains(one.lines().find(|line| line.starts_with("            3: [(")).unwrap()));
    // One frame alone is shown at any time.
    place.hfvdb("bake ball.toml --resolution 16 -o one.usda --frames 3").ok();
    let one = text(&place, "one.usda");
    assert!(samples(&one).is_empty() && one.contains("point3f[] points = [("));

    let bytes = whole.replacen("3: [", "3: [ ", 1);
    fs::write(place.path("out/ball.usda"), bytes).unwrap();
    place.hfvdb("verify out/ball.usda").fails(1, &["ball.usda", "changed"]);
}

#[test]
fn what_is_there_is_kept_replaced_or_refused() {
    let place = workplace();
    place.hfvdb(&format!("{BAKE} --frames 2-4")).ok();
    let first = text(&place, "out/ball.usda");
    place.hfvdb(&format!("{BAKE} --frames 2-4")).fails(1, &["out/ball.usda exists", "--resume", "--overwrite"]);
    let kept = place.hfvdb(&format!("{BAKE} --frames 2-4 --resume --json")).ok();
    let kept = json(&kept.stdout);
    let states: Vec<_> = kept["frames"].as_array().unwrap().iter().map(|frame| frame["state"].as_str()).collect();
    assert_eq!(states, [Some("kept"); 3]);
    assert_eq!(
        place.hfvdb(&format!("{BAKE} --frames 2-4 --resume --dry-run")).ok().stdout.lines().next(),
        Some("out/ball.usda kept")
    );
    // Other frames are another file.
    place.hfvdb(&format!("{BAKE} --frames 2-5 --resume")).ok();
    assert_eq!(samples(&text(&place, "out/ball.usda"))[0].1, [2, 3, 4, 5]);
    let other = BAKE.replace("ball.toml", "egg.toml");
    place.hfvdb(&format!("{other} --frames 2-4 --resume")).fails(1, &["another scene"]);
    place.hfvdb(&format!("{other} --frames 2-4 --overwrite")).ok();
    assert!(text(&place, "out/ball.usda") != first);
    place.hfvdb(&format!("{BAKE} --frames 2-4 --overwrite")).ok();
    assert!(text(&place, "out/ball.usda") == first);
    // Frames that are done are not thrown away for a few of them.
    for frames in ["2", "3-4", "2-3,5"] {
        place.hfvdb(&format!("{BAKE} --frames {frames} --resume")).fails(1, &["out/ball.usda holds frames 2-4"]);
    }
    assert!(text(&place, "out/ball.usda") == first);

    let lock = FileLock::try_take(&place.path("out/.ball.usda.hfvdb-lock")).unwrap();
    place.hfvdb(&format!("{BAKE} --frames 2-4 --overwrite")).fails(1, &["out/ball.usda", "another process writes"]);
    drop(lock);
    // What a killed process leaves goes.
    place.write("out/.ball.usda.abc123.hfvdb-tmp", "half of it");
    place.write("out/.ball.usda.12-34.hfvdb-run-lock", "");
    place.hfvdb(&format!("{BAKE} --frames 2-4 --overwrite")).ok();
    place.nothing_is_left("out");
    for other in ["glb", "ply", "obj", "vdb"] {
        let bake = BAKE.replace("usda", other);
        place.hfvdb(&bake).fails(2, &["24 frames would go into one file"]);
    }
}

/// Two balls that have nothing in common at the end, so that frames 4 and 5 are empty.
const PARTING: &str = "frames = '1-5'\n[shape.a]\nintersection = ['b', 'c']\n[shape.b]\nsphere = 1\n[shape.c]\n\
                       sphere = 1\nmove = ['3*t', 0, 0]\n[output]\nshape = 'a'\nvoxel_size = 0.1\n";

#[test]
fn frames_that_fail_are_gone_on_with() {
    let place = Workplace::new();
    place.write("parting.toml", PARTING);
    let told = place.hfvdb("bake parting.toml -o p.usda");
    told.fails(1, &["2 of 5 frames failed: 4-5", "3 of 5 frames are done, --resume goes on from there"]);
    assert!(!place.path("p.usda").exists() && place.path(".p.usda.hfvdb-frames/frame.0003.usda").exists());
    place.hfvdb("bake parting.toml -o p.usda --allow-empty").fails(1, &["frame.0001.usda exists", "--resume"]);
    let told = place.hfvdb("bake parting.toml -o p.usda --allow-empty --resume").ok();
    assert!(told.stderr.contains("3 of 5 frames are done"), "{}", told.stderr);
    let text = text(&place, "p.usda");
    assert!(samples(&text).iter().all(|(_, frames)| frames == &[1, 2, 3, 4, 5]));
    assert_eq!(text.matches("            4: [],\n").count(), 4, "it shows nothing, and not what was before");
    assert!(!place.path(".p.usda.hfvdb-frames").exists());
}

#[test]
fn files_of_voxels_become_one_of_polygons() {
    let place = workplace();
    let grids = "--set output.grids=[\"surface\",\"Cd\",\"vel\"]";
    place.hfvdb(&format!("bake ball.toml --resolution 16 -o out/m.####.vdb --frames 2-4 {grids}")).ok();
    place.hfvdb("mesh out/m.####.vdb -o m.usda").ok();
    let text = text(&place, "m.usda");
    let names: Vec<String> = samples(&text).into_iter().map(|(name, _)| name).collect();
    assert!(names.contains(&"vector3f[] velocities".to_owned()), "{names:?}");
    assert!(samples(&text).iter().all(|(_, frames)| frames == &[2, 3, 4]));
    place
        .hfvdb("bake ball.toml -o m.glb --frames 2 --set output.grids=[\"surface\",\"vel\"]")
        .fails(2, &[".usda alone holds `vel`"]);
}
